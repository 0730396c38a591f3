// R(q) at the end of one step is R(q) at the start of the next, and so is K(q): keep them, unless q
// was changed meanwhile from outside.
#pragma once

#include <limits>
#include <optional>

#include <Eigen/Core>

#include "runtime/kernels/potential.h"

namespace tremolo {

class ForceCache {
 public:
  explicit ForceCache(const Potential& potential, bool all = false)
      : potential_(potential),
        want_(kWantEnergy | kWantForce | (all ? kWantTangent : 0u)),
        workspace_(potential.make_workspace(all ? kUseTangent : kUsePoint)),
        evaluation_(potential.make_evaluation()),
        q_(Eigen::VectorXd::Constant(potential.size(), std::numeric_limits<double>::quiet_NaN())) {}

  // R(q), valid until the next call. Evaluates only if q is not the one of the last call.
  const Eigen::VectorXd& force(const Eigen::VectorXd& q) {
    evaluate(q);
    return evaluation_.force;
  }

  // V(q) if q is that of the last call: it came with the force.
  std::optional<double> known_energy(const Eigen::VectorXd& q) const {
    if (q_ == q) return evaluation_.energy;
    return std::nullopt;
  }

  // V(q) and K(q), as force(); K for a cache made with `all`.
  double energy(const Eigen::VectorXd& q) {
    evaluate(q);
    return evaluation_.energy;
  }
  const Eigen::MatrixXd& tangent(const Eigen::VectorXd& q) {
    evaluate(q);
    return evaluation_.tangent;
  }

 private:
  void evaluate(const Eigen::VectorXd& q) {
    if (q_ == q) return;  // NaN, as at the start, is never equal
    potential_.evaluate(q, want_, workspace_, evaluation_);
    q_ = q;
  }

  const Potential& potential_;
  unsigned want_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd q_;
};

}  // namespace tremolo
