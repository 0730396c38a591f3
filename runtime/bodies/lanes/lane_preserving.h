// Steps of avf, ep2 and ep4 (runtime/bodies/reduced/integrators/energy_preserving.cpp) for blocks
// of bodies of one model.
//
// The solve is that of one body. The first correction needs no evaluation of the force where the
// step before is known. An evaluation with the tangent there makes N and the Jacobian; then each
// correction costs an evaluation of the mean force, with Broyden's updates. A lane that has
// converged is finished at once and keeps its result. A lane that needs more than kMostSegments
// evaluations with the tangent, or more than kMostMeans without, is stepped by the solver of one
// body, which searches along lines, uses the exact Jacobian and halves the step. So no lane delays
// the others for longer. The decisions depend on the lane's own numbers only.
//
// State, Lambda q, N, the Jacobian and all sums are in double; the precision of a group is that of
// grad (C + Q) and its tangent (runtime/bodies/lanes/lane_segment.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "runtime/bodies/lanes/lane_segment.h"
#include "runtime/bodies/lanes/lane_solve.h"
#include "runtime/integrator.h"
#include "runtime/model.h"

namespace tremolo {

// True for the methods of LanePreserving.
bool preserves_energy_in_lanes(std::string_view integrator);

// Buffers of one thread.
struct LanePreservingScratch {
  AlignedDoubles rows;      // scratch of LaneSolve for each half of a block
  AlignedDoubles segments;  // middle, half, mean, tangent and the scratch of an evaluation
};

class LanePreserving {
 public:
  // options as for make_integrator, without beta. coefficients: those of the group's lane_force.
  template <class Real>
  static LanePreserving create(std::string_view integrator, Model::Pointer model,
                               const IntegratorOptions& options,
                               const LaneCoefficients<Real>& coefficients);

  // Memory for a number of blocks; the bodies of new ones are unknown.
  void reserve(std::size_t blocks);
  // Grows the scratch, and makes the solver for the lanes that need one body's, for a thread.
  void make_scratch(LanePreservingScratch& scratch, std::size_t thread);

  // A lane is slot % lanes of block slot / lanes.
  void forget(std::size_t slot);                // the state was set: nothing is known
  void move(std::size_t from, std::size_t to);  // what is known moves with a body
  double dissipated(std::size_t slot) const { return dissipated_[slot]; }  // J, of the last step

  struct Block {
    std::size_t index = 0;
    std::size_t bodies = 0;     // in its leading lanes
    double* q = nullptr;        // rows of all lanes, r
    double* p = nullptr;        // the same
    const double* f = nullptr;  // the load; null: none
  };
  // Bits of the lanes that no solver can step; their state is unchanged.
  struct Failed {
    std::uint32_t all = 0;
    std::uint32_t gave_up = 0;  // those without a number that overflowed
  };
  // Nothing is allocated, except by the first step that is subdivided.
  Failed step(const Block& block, LanePreservingScratch& scratch, std::size_t thread);

 private:
  struct Lone {
    std::unique_ptr<Integrator> integrator;
    State state;
    StepLoad load;
  };
  struct Solve;
  LanePreserving() = default;

  std::size_t width() const { return lanes_ / kSolveLanes; }
  double* saved(std::size_t block, std::size_t half) {
    return saved_.data() + (block * width() + half) * system_.layout.saved_rows * kSolveLanes;
  }
  void step_alone(const Block& block, std::size_t lane, Lone& lone, Failed& failed);

  LaneSystem system_;
  std::variant<SegmentCoefficients<double>, SegmentCoefficients<float>> segment_;
  std::size_t lanes_ = 0;  // bodies per block
  std::string integrator_;
  Model::Pointer model_;
  IntegratorOptions options_;
  AlignedDoubles saved_;              // for each half of a block
  std::vector<std::uint32_t> known_;  // bits of the lanes whose last step is saved, one per block
  std::vector<double> dissipated_;    // J, of the last step, one per slot
  std::vector<Lone> lone_;            // one per thread
};

}  // namespace tremolo
