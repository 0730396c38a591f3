#include "runtime/bodies/reduced/integrators/solve/step_ends.h"

#include <limits>
#include <utility>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr unsigned kAll = kWantEnergy | kWantForce | kWantTangent;

}  // namespace

StepEnds::StepEnds(const Potential& potential)
    : potential_(potential),
      workspace_(potential.make_workspace(kUseTangent)),
      start_(potential.make_evaluation()),
      end_(start_),
      middle_(start_),
      start_q_(VectorXd::Constant(potential.size(), std::numeric_limits<double>::quiet_NaN())),
      bend_(VectorXd::Zero(potential.size())),
      image0_(bend_),
      image1_(bend_),
      start_move_(bend_),
      end_move_(bend_) {}

void StepEnds::start_at(const VectorXd& q0) {
  end_known_ = false;
  if (start_q_ == q0) return;
  potential_.evaluate(q0, kAll, workspace_, start_);
  start_q_ = q0;
  start_move_.setZero();
}

void StepEnds::end_at(const VectorXd& q1, const VectorXd& d, VectorXd& G) {
  evaluate_end(q1);
  set_mean(d, G);
}

void StepEnds::evaluate_end(const VectorXd& q1) {
  potential_.evaluate(q1, kAll, workspace_, end_);
  end_move_.setZero();
  end_known_ = true;
}

void StepEnds::end_near(const VectorXd& move, const VectorXd& q1, const VectorXd& d, VectorXd& G) {
  potential_.evaluate(q1, kWantEnergy | kWantForce, workspace_, end_);
  end_move_ += move;
  set_mean(d, G);
}

void StepEnds::set_mean(const VectorXd& d, VectorXd& G) {
  image1_ = d + end_move_ - start_move_;
  bend_.noalias() = end_.tangent * image1_;
  bend_.noalias() -= start_.tangent * image1_;
  bend_ /= 12.0;
  G = 0.5 * (start_.force + end_.force) - bend_;
}

void StepEnds::mean_derivative(const VectorXd& middle, Eigen::MatrixXd& out) {
  potential_.evaluate(middle, kWantTangent, workspace_, middle_);
  out = middle_.tangent / 3.0 + end_.tangent / 6.0;
}

void StepEnds::move_end(const VectorXd& move, const VectorXd& q1, VectorXd& G, VectorXd& bent) {
  image0_.noalias() = start_.tangent * move;
  image1_.noalias() = end_.tangent * move;
  bent = 0.5 * (image0_ + image1_);
  G += image0_ / 6.0 + image1_ / 3.0;
  end_.force += image1_;
  end_move_ += move;
  potential_.evaluate(q1, kWantEnergy, workspace_, end_);
}

// A step whose prediction is exact evaluates nothing, like those of a body at rest. What end_ holds
// is then older, or nothing after a restore.
void StepEnds::accept(const VectorXd& q1) {
  if (!end_known_) {
    if (q1 == start_q_) return;
    evaluate_end(q1);
  }
  std::swap(start_, end_);
  start_q_ = q1;
  start_move_ = end_move_;
}

void StepEnds::forget() {
  start_q_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

void StepEnds::carry(StateStream& stream) {
  stream(start_q_, start_.energy, start_.force, start_.tangent, start_move_);
}

}  // namespace tremolo
