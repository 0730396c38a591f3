// V, its gradient R and its tangent K at the last place where they were evaluated. The end of one
// step is the start of the next, so what is known there is used again unless q was changed from
// outside meanwhile.
#pragma once

#include <limits>
#include <optional>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/kernels/potential.h"

namespace tremolo {

class PotentialCache {
 public:
  // The potential must live on. want: what the functions that remember evaluate together.
  // uses: what evaluate() may be asked for beyond energy and force.
  PotentialCache(const Potential& potential, unsigned want, unsigned uses)
      : potential_(potential),
        want_(want),
        workspace_(potential.make_workspace(uses)),
        at_q_(potential.make_evaluation()),
        q_(Eigen::VectorXd::Constant(potential.size(), std::numeric_limits<double>::quiet_NaN())) {}

  // Each remembers: it evaluates only where q is not the one of the last evaluation, and its result
  // is valid until the next one. `want` must name what is asked for.
  double energy(const Eigen::VectorXd& q) { return remember(q).energy; }
  const Eigen::VectorXd& force(const Eigen::VectorXd& q) { return remember(q).force; }
  const Eigen::MatrixXd& tangent(const Eigen::VectorXd& q) { return remember(q).tangent; }

  // Evaluates what `want` names here, whatever is known; all that the constructor's `want` names
  // must be among it.
  Evaluation& evaluate(const Eigen::VectorXd& q, unsigned want) {
    potential_.evaluate(q, want, workspace_, at_q_);
    q_ = q;
    return at_q_;
  }

  // V(q), J, where q is that of the last evaluation and V came with it.
  std::optional<double> known_energy(const Eigen::VectorXd& q) const {
    if ((want_ & kWantEnergy) != 0 && q_ == q) return at_q_.energy;
    return std::nullopt;
  }

  // What is remembered: evaluated anew with other parts it may differ in the last digit.
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
