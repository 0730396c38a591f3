#include "runtime/response/static_state.h"

#include <algorithm>
#include <limits>

#include <Eigen/Core>

#include "common/text.h"
#include "runtime/math/dense/decompositions.h"
#include "runtime/math/dense/dense_lu.h"

namespace tremolo {
namespace {

// Newton's method at one load, from q on. False: it did not converge. Where the body is soft its
// rounding keeps the corrections above the first limit: they end where they fall no more.
bool settle(const Potential& potential, const Eigen::VectorXd& force, PotentialWorkspace& workspace,
            Evaluation& at, Eigen::VectorXd& q) {
  constexpr double kExact = 1e-13, kRounded = 1e-9;  // of q
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 20; ++i) {
    potential.evaluate(q, kWantForce | kWantTangent, workspace, at);
    const Eigen::VectorXd correction = DenseLu(at.tangent).solve(force - at.force);
    q += correction;
    if (!q.allFinite()) return false;
    const double size = correction.norm(), whole = q.norm();
    const bool rounded = size <= kRounded * whole && size > 0.5 * before;
    before = size;
    if (size <= kExact * whole || rounded) {
      potential.evaluate(q, kWantForce | kWantTangent, workspace, at);
      return true;
    }
  }
  return false;
}

// True if the step from q to `trial` is near the one that the tangent at q predicts: the state did
// not jump to another branch.
bool is_near(const Eigen::VectorXd& predicted, const Eigen::VectorXd& made) {
  return (made - predicted).norm() <= 0.1 * predicted.norm();
}

// The message for a force of which the part `done` has the last state that was found, q.
Error not_found(const Potential& potential, PotentialWorkspace& workspace, Evaluation& at,
                const Eigen::VectorXd& q, double done) {
  constexpr double kNearZero = 0.1;  // of the least stiffness without force
  const auto least_stiffness = [&](const Eigen::VectorXd& where) {
    potential.evaluate(where, kWantTangent, workspace, at);
    return symmetric_eigenvalues(at.tangent)[0];
  };
  const double at_rest = least_stiffness(Eigen::VectorXd::Zero(q.size()));
  if (least_stiffness(q) < kNearZero * at_rest)
    return Error{ErrorKind::kContent,
                 "the constant force is beyond a static instability: at " + number_text(done) +
                     " of it the stiffness stops being positive (the body buckles or snaps "
                     "through); use a smaller constant force"};
  return Error{ErrorKind::kContent,
               "no state at rest was found beyond " + number_text(done) +
                   " of the constant force, where the body is stiff; use a smaller constant force"};
}

}  // namespace

Result<Eigen::VectorXd> static_state(const Potential& potential, const Eigen::VectorXd& force) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(potential.size());
  if (force.isZero(0.0)) return q;
  PotentialWorkspace workspace = potential.make_workspace(kUseTangent);
  Evaluation at = potential.make_evaluation();
  // A force of many times what bends the body far needs small first parts.
  constexpr double kLeastPart = 1e-12;
  double done = 0.0, part = 0.125;
  while (done < 1.0) {
    const double next = std::min(1.0, done + part);
    potential.evaluate(q, kWantTangent, workspace, at);
    const Eigen::VectorXd predicted = DenseLu(at.tangent).solve((next - done) * force);
    Eigen::VectorXd trial = q;
    if (settle(potential, next * force, workspace, at, trial) && is_near(predicted, trial - q) &&
        is_positive_definite(at.tangent)) {
      q = std::move(trial);
      done = next;
      part *= 1.5;
      continue;
    }
    part *= 0.5;
    if (part < kLeastPart) return not_found(potential, workspace, at, q, done);
  }
  return q;
}

}  // namespace tremolo
