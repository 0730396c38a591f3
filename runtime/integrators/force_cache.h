// R(q) at the end of one step is R(q) at the start of the next: keep it, unless q was changed
// meanwhile from outside.
#pragma once

#include <limits>

#include <Eigen/Core>

#include "runtime/potential.h"

namespace tremolo {

class ForceCache {
 public:
  explicit ForceCache(const Potential& potential)
      : potential_(potential),
        workspace_(potential.make_workspace()),
        evaluation_(potential.make_evaluation()),
        q_(Eigen::VectorXd::Constant(potential.size(), std::numeric_limits<double>::quiet_NaN())) {}

  // R(q), valid until the next call. Evaluates only if q is not the one of the last call.
  const Eigen::VectorXd& force(const Eigen::VectorXd& q) {
    if (q_ != q) {  // NaN, as at the start, is never equal
      potential_.evaluate(q, kWantForce, workspace_, evaluation_);
      q_ = q;
    }
    return evaluation_.force;
  }

 private:
  const Potential& potential_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd q_;
};

}  // namespace tremolo
