// A body is stepped in blocks without interruption; the states are examined after each block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/body.h"

namespace tremolo {

// The state of a body at the end of a step. work, dissipated, iterations and halved_steps count
// from the start.
struct Moment {
  std::int64_t steps = 0;
  double time = 0.0;  // s
  State state;        // p: the momentum at the time of q
  double work = 0.0;        // J
  double dissipated = 0.0;  // J
  std::int64_t iterations = 0;
  std::int64_t halved_steps = 0;
  bool loaded = false;         // a load can still act
  std::optional<Split> split;  // of a splitting method
  EnergyBound bound;           // with the energy put in so far
};

// Copies the body's state into `moment`; allocates only if it has not held as many coordinates
// before.
void look_at(const Body& body, Moment& moment);

// Steps a body in blocks. Energies, shapes and CSV rows use far more memory than a step and would
// evict a step's data from the caches: so the states of a block are stored, and examined when the
// block is complete.
class March {
 public:
  // block: steps at once, at least 1. The body must outlive this.
  March(Body& body, std::size_t block);

  // Makes the next block of steps, which is shorter where the body reaches `last` steps or a step
  // does not converge. The result is valid until the next call.
  std::span<const Moment> advance(std::int64_t last);

  // The step that did not converge, after the last state; nullopt while all have.
  const std::optional<StepReport>& failed() const { return failed_; }
  // The mean processor time of a step in microseconds: this thread's, over all blocks.
  double microseconds_per_step() const;

 private:
  Body& body_;
  std::vector<Moment> moments_;
  std::optional<StepReport> failed_;
  double seconds_ = 0.0;
  std::int64_t tried_ = 0;
};

}  // namespace tremolo
