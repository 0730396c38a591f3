#include "runtime/response/static_state.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/text.h"

namespace tremolo {
namespace {

// Newton's method at one load, from q on. False: it did not converge.
bool settle(const Potential& potential, const Eigen::VectorXd& force, PotentialWorkspace& workspace,
            Evaluation& at, Eigen::VectorXd& q) {
  for (int i = 0; i < 20; ++i) {
    potential.evaluate(q, kWantForce | kWantTangent, workspace, at);
    const Eigen::VectorXd correction = at.tangent.partialPivLu().solve(force - at.force);
    q += correction;
    if (!q.allFinite()) return false;
    if (correction.norm() <= 1e-13 * q.norm()) {
      potential.evaluate(q, kWantForce | kWantTangent, workspace, at);
      return true;
    }
  }
  return false;
}

// True if the step from q to `trial` is near the one that the tangent at q predicts: the state did
// not jump to another branch.
bool is_near(const Eigen::VectorXd& predicted, const Eigen::VectorXd& made) {
  return (made - predicted).norm() <= 0.5 * predicted.norm();
}

}  // namespace

Result<Eigen::VectorXd> static_state(const Potential& potential, const Eigen::VectorXd& force) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(potential.size());
  if (force.isZero(0.0)) return q;
  PotentialWorkspace workspace = potential.make_workspace(kUseTangent);
  Evaluation at = potential.make_evaluation();
  constexpr double kLeastPart = 1e-5;
  double done = 0.0, part = 0.125;
  while (done < 1.0) {
    const double next = std::min(1.0, done + part);
    potential.evaluate(q, kWantTangent, workspace, at);
    const Eigen::VectorXd predicted = at.tangent.partialPivLu().solve((next - done) * force);
    Eigen::VectorXd trial = q;
    if (settle(potential, next * force, workspace, at, trial) && is_near(predicted, trial - q) &&
        at.tangent.llt().info() == Eigen::Success) {
      q = std::move(trial);
      done = next;
      part *= 1.5;
      continue;
    }
    part *= 0.5;
    if (part < kLeastPart)
      return content_error("the constant force is beyond a static instability: at " +
                           number_text(done) +
                           " of it the stiffness stops being positive (the body buckles or snaps "
                           "through); use a smaller constant force");
  }
  return q;
}

}  // namespace tremolo
