// V, its gradient R and its tangent K at the position of the last evaluation. The end of one step
// is the start of the next, so the values are used again unless q was changed from outside in
// between.
#pragma once

#include <limits>
#include <optional>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/math/kernels/potential.h"

namespace tremolo {

class PotentialCache {
 public:
  // The potential must outlive this. want: the values that the caching functions evaluate together.
  // uses: the further values that evaluate() may be asked for, in addition to energy and force.
  PotentialCache(const Potential& potential, unsigned want, unsigned uses)
      : potential_(potential),
        want_(want),
        workspace_(potential.make_workspace(uses)),
        at_q_(potential.make_evaluation()),
        q_(Eigen::VectorXd::Constant(potential.size(), std::numeric_limits<double>::quiet_NaN())) {}

  // These functions cache: they evaluate only if q is not that of the last evaluation, and a result
  // is valid until the next one. `want` must include the requested value.
  double energy(const Eigen::VectorXd& q) { return remember(q).energy; }
  const Eigen::VectorXd& force(const Eigen::VectorXd& q) { return remember(q).force; }
  const Eigen::MatrixXd& tangent(const Eigen::VectorXd& q) { return remember(q).tangent; }

  // Evaluates the values in `want` in any case; they must include all values of the constructor's
  // `want`.
  Evaluation& evaluate(const Eigen::VectorXd& q, unsigned want) {
    potential_.evaluate(q, want, workspace_, at_q_);
    q_ = q;
    return at_q_;
  }

  // V(q), J, if q is that of the last evaluation and V was among its values.
  std::optional<double> known_energy(const Eigen::VectorXd& q) const {
    if ((want_ & kWantEnergy) != 0 && q_ == q) return at_q_.energy;
    return std::nullopt;
  }

  // Saves or restores the cached values: another evaluation with other parts may differ in the last
  // digit.
  void carry(StateStream& stream) {
    stream(q_, at_q_.energy, at_q_.force);
    stream(at_q_.tangent);
  }

 private:
  const Evaluation& remember(const Eigen::VectorXd& q) {
    return q_ == q ? at_q_ : evaluate(q, want_);  // NaN, as at the start, is never equal
  }

  const Potential& potential_;
  unsigned want_;
  PotentialWorkspace workspace_;
  Evaluation at_q_;
  Eigen::VectorXd q_;
};

}  // namespace tremolo
