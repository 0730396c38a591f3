// V, its gradient g and its tangent K at both ends of a step from q0 to q1 = q0 + d, for ep4.
//
// V is quartic, so that g is cubic on the segment. Its mean G, which ep4 needs, follows from the
// ends alone, exactly (Hermite's formula), and so does the tangent near the middle m:
//
//     G = (g0 + g1)/2 - (K1 - K0) d/12,      (K0 + K1)/2 = K(m) + O(d^2),
//     dG = (K0/6 + K1/3) dq1 + O(d^2 dq1).
//
// The end of a step is the start of the next. So a step costs one evaluation, of all three at an
// end q1 near the solution. After a small move x of q1 only V and g are evaluated again, or, after
// the last move of all, V: then g and G follow to first order. K stays that of q1 - x. Since the
// third derivative of V is symmetric, K'[x] d = K'[d] x, and near (K1 - K0) x. So with the moves x0
// and x1 of the two ends since their tangents were evaluated
//
//     (K1 - K0) d  becomes  (K1 - K0) (d - x0 + x1),
//
// whose error is of second order in the moves, or first in them and second in d.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/math/kernels/potential.h"

namespace tremolo {

class StepEnds {
 public:
  explicit StepEnds(const Potential& potential);  // must outlive this

  // Makes q0, r, the start. Evaluates nothing if the last accepted end is there.
  void start_at(const Eigen::VectorXd& q0);
  // At the start: energy V0, J; force g0, r; tangent K0, r x r.
  const Evaluation& start() const { return start_; }

  // Evaluates the end q1 and sets G, r.
  void end_at(const Eigen::VectorXd& q1, const Eigen::VectorXd& d, Eigen::VectorXd& G);
  // Evaluates V and its gradient alone at the end after a move to q1 = q0 + d, and sets G.
  void end_near(const Eigen::VectorXd& move, const Eigen::VectorXd& q1, const Eigen::VectorXd& d,
                Eigen::VectorXd& G);
  void mean_tangent(Eigen::MatrixXd& K) const { K = 0.5 * (start_.tangent + end_.tangent); }

  // The derivative of G with respect to q1, exact, r x r: Simpson's mean of s K, which takes an
  // evaluation in the middle, (q0 + q1)/2.
  void mean_derivative(const Eigen::VectorXd& middle, Eigen::MatrixXd& out);

  // Moves the end by `move`, to q1, and G with it. bent: receives (K0 + K1)/2 move, r.
  void move_end(const Eigen::VectorXd& move, const Eigen::VectorXd& q1, Eigen::VectorXd& G,
                Eigen::VectorXd& bent);
  // The share of d by which the end has moved since its tangent was evaluated, after a move.
  double share(const Eigen::VectorXd& move, const Eigen::VectorXd& d) const {
    return (end_move_ + move).norm() / d.norm();
  }
  // How much of G's second part a small share corrects; what it leaves is smaller by another.
  double lag(double share) const { return share * bend_.norm(); }

  double work() const { return end_.energy - start_.energy; }  // V1 - V0, J
  // V where the last accepted end is q; none elsewhere.
  std::optional<double> known_energy(const Eigen::VectorXd& q) const {
    return start_q_ == q ? std::optional(start_.energy) : std::nullopt;
  }

  // The step is done: its end q1 becomes the start of the next. Evaluates the end if the step did
  // not, unless it is the start.
  void accept(const Eigen::VectorXd& q1);
  void forget();  // the start is not known

  // Saves or restores what the next step begins with.
  void carry(StateStream& stream);

 private:
  void evaluate_end(const Eigen::VectorXd& q1);
  void set_mean(const Eigen::VectorXd& d, Eigen::VectorXd& G);

  const Potential& potential_;
  PotentialWorkspace workspace_;
  Evaluation start_, end_, middle_;
  bool end_known_ = false;   // end_ is of this step
  Eigen::VectorXd start_q_;  // of start_, NaN if it is not known
  Eigen::VectorXd bend_;     // (K1 - K0) d/12
  Eigen::VectorXd image0_, image1_;
  Eigen::VectorXd start_move_, end_move_;  // moves since K0 and K1 were evaluated
};

}  // namespace tremolo
