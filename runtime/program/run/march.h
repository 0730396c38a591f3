// Steps in blocks, with nothing between them; what came of each is looked at afterwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/body.h"

namespace tremolo {

// A body as it was at the end of a step. state.p: the momentum at the time of state.q. work,
// dissipated, iterations, halved_steps: since the start, as Body tells them. loaded: a load can
// still act. split: of a method that splits. bound: what has been put in so far.
struct Moment {
  std::int64_t steps = 0;
  double time = 0.0;  // s
  State state;
  double work = 0.0;        // J
  double dissipated = 0.0;  // J
  std::int64_t iterations = 0;
  std::int64_t halved_steps = 0;
  bool loaded = false;
  std::optional<Split> split;
  EnergyBound bound;
};

// Copies; allocates only if `moment` has not held as many coordinates before.
void look_at(const Body& body, Moment& moment);

// Energies, shapes and rows of a CSV need far more memory than a step: between two steps they would
// take the step's own numbers out of the caches. So the moments of a block are kept, and looked at
// when it is complete.
class March {
 public:
  // block: steps at once, at least 1. The body must outlive this.
  March(Body& body, std::size_t block);

  // The next block, shorter where the body reaches `last` steps or a step does not converge. Valid
  // until the next call.
  std::span<const Moment> advance(std::int64_t last);

  // The step that did not converge; it is behind the last moment.
  const std::optional<StepReport>& failed() const { return failed_; }
  // Processor time of a step, microseconds: that of this thread in all blocks over their steps.
  double microseconds_per_step() const;

 private:
  Body& body_;
  std::vector<Moment> moments_;
  std::optional<StepReport> failed_;
  double seconds_ = 0.0;
  std::int64_t tried_ = 0;
};

}  // namespace tremolo
