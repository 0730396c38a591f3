#include "runtime/bodies/tets/motion/tet_sums.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

TetSums::TetSums(const TetBody& body)
    : first_(body.positions().head(static_cast<Eigen::Index>(3 * body.model().vertices()))),
      share_(body.system().quadratic_share()) {}

void TetSums::add(const TetBody& body, const TetStepReport& step) {
  ++count_;
  iterations_ += step.iterations;
  switched_ += static_cast<std::int64_t>(step.switched);
  in_parts_ += step.parts > 1 ? 1 : 0;
  linearised_ += step.linearised ? 1 : 0;
  unsolved_ += step.unsolved ? 1 : 0;
  guarded_ += step.guarded > 0 ? 1 : 0;
  energy_of_switches_ += step.energy_of_switch;
  jump_ = std::max(jump_, step.jump);
  share_ += body.system().quadratic_share();
  double squared = 0.0;
  for (Eigen::Index i = 0; i < first_.size(); i += 3)
    squared =
        std::max(squared, (body.positions().segment<3>(i) - first_.segment<3>(i)).squaredNorm());
  displacement_ = std::max(displacement_, std::sqrt(squared));
}

void TetSums::carry(StateStream& stream) {
  stream(count_, iterations_, switched_, in_parts_, linearised_, unsolved_, guarded_);
  stream(energy_of_switches_, jump_, share_, displacement_);
  stream.require(count_ >= 1);
}

}  // namespace tremolo
