#include "runtime/frames/driven_frame.h"

#include <utility>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d spin_between(const Pose& start, const Pose& end, double step) {
  return turn_of(start.rotation.conjugate() * end.rotation) / step;
}

}  // namespace

FrameMotion motion_between(const Pose& before, const Pose& start, const Pose& end,
                           const Pose& after, double step) {
  const Vector3d last = (start.position - before.position) / step;
  const Vector3d next = (after.position - end.position) / step;
  return {(next - last) / (2.0 * step), spin_between(start, end, step),
          (spin_between(end, after, step) - spin_between(before, start, step)) / (2.0 * step)};
}

DrivenFrame::DrivenFrame(std::shared_ptr<const FrameInertia> inertia, double step)
    : inertia_(std::move(inertia)), step_(step) {
  const Index r = inertia_->modes();
  for (VectorXd* v : {&push_, &gravity_push_, &q0_, &x_, &stiff_}) v->setZero(r);
  stiffness_.setZero(r, r);
  gyro_.setZero(r, r);
  turn_.setIdentity(r, r);
  turn_factor_.compute(turn_);
}

void DrivenFrame::teleport(const Pose& pose) {
  pose_ = next_ = pose;
  known_ = false;
  velocity_.setZero();
  spin_.setZero();
  acceleration_.setZero();
  spin_rate_.setZero();
}

void DrivenFrame::move_to(const Pose& next) {
  next_ = next;
  known_ = false;
}

void DrivenFrame::move_to(const Pose& next, const FrameMotion& motion) {
  next_ = next;
  motion_ = motion;
  known_ = true;
}

void DrivenFrame::prepare(const Vector3d& gravity) {
  const Vector3d velocity = (next_.position - pose_.position) / step_;
  const Vector3d spin = spin_between(pose_, next_, step_);
  if (!known_) {
    const Vector3d acceleration = (velocity - velocity_) / step_;
    const Vector3d spin_rate = (spin - spin_) / step_;
    motion_ = {1.5 * acceleration - 0.5 * acceleration_, spin, 1.5 * spin_rate - 0.5 * spin_rate_};
  }
  mid_rotation_ = (pose_.rotation * turn_by(0.5 * step_ * spin)).toRotationMatrix();
  const Vector3d g = mid_rotation_.transpose() * gravity;
  const Vector3d a = mid_rotation_.transpose() * motion_.acceleration;
  gravity_push_.noalias() = inertia_->s.transpose() * g;
  push_.noalias() = inertia_->s.transpose() * (-a);
  push_ += gravity_push_;
  turning_ = !motion_.spin.isZero(0.0) || !motion_.spin_rate.isZero(0.0);
  turned_work_ = 0.0;
  if (turning_) prepare_turn();
  push_norm_ = push_.norm();
}

// The constant parts go to push_, what is linear in q and v to stiffness_ and gyro_.
void DrivenFrame::prepare_turn() {
  const Index r = inertia_->modes();
  const Vector3d& w = motion_.spin;
  const Vector3d& rate = motion_.spin_rate;
  push_.noalias() -= inertia_->a.transpose() * rate;
  stiffness_.setZero();
  stiffness_.diagonal().setConstant(-w.squaredNorm());
  gyro_.setZero();
  for (Index m = 0; m < 3; ++m) {
    const auto c = inertia_->pairs.middleRows(m * r, r);
    stiffness_ -= rate[m] * c;
    gyro_ -= (2.0 * w[m]) * c;
  }
  for (Index e = 0; e < 6; ++e) {
    const auto& [k, l] = kSymmetricEntries[static_cast<std::size_t>(e)];
    const double ww = w[k] * w[l] * (k == l ? 1.0 : 2.0);
    stiffness_ += ww * inertia_->pairs.middleRows((3 + e) * r, r);
    push_ += 0.5 * ((k == l ? w.squaredNorm() : 0.0) - ww) * inertia_->P_linear.col(e);
  }
}

void DrivenFrame::half_turn(bool first, State& state) {
  const double h = step_;
  if (first) {
    turn_ = (0.25 * h) * gyro_;
    turn_.diagonal().array() += 1.0;
    turn_factor_.compute(turn_);
  }
  const auto turn = [&] {
    x_ = state.p;
    x_.noalias() -= (0.25 * h) * gyro_ * state.p;
    state.p.noalias() = turn_factor_.solve(x_);
  };
  if (first) turn();
  const double before = state.p.squaredNorm();
  state.p.noalias() -= (0.5 * h) * stiffness_ * state.q;
  turned_work_ += 0.5 * (state.p.squaredNorm() - before);
  if (!first) turn();
}

void DrivenFrame::begin(double h, const VectorXd& q0, const VectorXd&) {
  h_ = h;
  q0_ = q0;
}

void DrivenFrame::evaluate(const VectorXd& d, const VectorXd&, VectorXd&, VectorXd& force) {
  x_ = q0_ + 0.5 * d;
  stiff_.noalias() = stiffness_ * x_;
  force += stiff_;
  force.noalias() += (1.0 / h_) * gyro_ * d;
}

bool DrivenFrame::finish(const VectorXd& d, double, VectorXd&) {
  turned_work_ -= stiff_.dot(d);
  return false;
}

void DrivenFrame::end_step(const VectorXd& q0, const VectorXd& q1) {
  x_ = q1 - q0;
  const double gravity = gravity_push_.dot(x_);
  gravity_work_ += gravity;
  support_work_ += push_.dot(x_) - gravity + turned_work_;
  const Vector3d velocity = (next_.position - pose_.position) / step_;
  const Vector3d spin = spin_between(pose_, next_, step_);
  acceleration_ = (velocity - velocity_) / step_;
  spin_rate_ = (spin - spin_) / step_;
  velocity_ = velocity;
  spin_ = spin;
  pose_ = next_;
  known_ = false;
}

void DrivenFrame::cancel_step() {
  turned_work_ = 0.0;
}

}  // namespace tremolo
