// Selects the steps after which a run measures the shape of a body. A measurement costs as much as
// hundreds of steps; for a sound with its hundred thousand steps, measuring always would dominate.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "runtime/model.h"
#include "runtime/program/run/stretch.h"

namespace tremolo {

class ShapeLooks {
 public:
  // Every `least` steps, or kLooks times in `steps` steps where that is rarer. Then the body is
  // also seen where, every `least` steps, a bound of its displacement, sum_i |q_i| max |U_i|, is
  // larger by a twentieth than ever before: the largest motion does not pass unseen.
  static constexpr std::int64_t kLooks = 1000;
  ShapeLooks(const Model& model, std::int64_t least, std::int64_t steps);

  // q: after the step of that number; call it once for every step.
  bool due(std::int64_t step, const Eigen::VectorXd& q);

  // False if at q no vertex of the boundary can be farther than `displacement`, m, and no triangle
  // stretched beyond the range: the measurement can be skipped.
  bool can_exceed(const Eigen::VectorXd& q, double displacement, const StretchRange& range) const;

 private:
  std::int64_t least_, every_;
  double record_ = 0.0;     // m, the largest bound so far
  Eigen::VectorXd reach_;   // the farthest that a unit of each coordinate moves any vertex, r
  Eigen::VectorXd strain_;  // the largest gradient of it over any triangle, 1/m times m, r
};

}  // namespace tremolo
