#include "runtime/bodies/reduced/frames/driven_frame.h"

#include <array>
#include <utility>

#include "runtime/math/dense/small_matrices.h"

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
    : DrivenFrame(std::vector{std::move(inertia)}, step) {}

DrivenFrame::DrivenFrame(const std::vector<std::shared_ptr<const FrameInertia>>& shares,
                         double step)
    : step_(step) {
  for (const auto& share : shares) bones_.emplace_back().inertia = share;
  const Index r = shares.front()->modes();
  for (VectorXd* v : {&push_, &gravity_push_, &q0_, &x_}) v->setZero(r);
  for (VectorXd* v : {&stiff_, &whirl_}) v->setZero(tall_rows(r));
  stiffness_.setZero(tall_rows(r), r);
  gyro_.setZero(tall_rows(r), r);
  turn_.setIdentity(r, r);
  turn_factor_.compute(turn_);
}

void DrivenFrame::teleport(const Pose& pose, std::size_t bone) {
  Bone fresh;
  fresh.inertia = std::move(bones_[bone].inertia);
  fresh.pose = fresh.next = pose;
  bones_[bone] = std::move(fresh);
}

void DrivenFrame::move_to(const Pose& next, std::size_t bone) {
  bones_[bone].next = next;
  bones_[bone].known = false;
}

void DrivenFrame::move_to(const Pose& next, const FrameMotion& motion, std::size_t bone) {
  bones_[bone].next = next;
  bones_[bone].motion = motion;
  bones_[bone].known = true;
}

void DrivenFrame::find_motion(Bone& bone) const {
  const Vector3d velocity = (bone.next.position - bone.pose.position) / step_;
  const Vector3d spin = spin_between(bone.pose, bone.next, step_);
  if (!bone.known) {
    const Vector3d acceleration = (velocity - bone.velocity) / step_;
    const Vector3d spin_rate = (spin - bone.spin) / step_;
    bone.motion = {1.5 * acceleration - 0.5 * bone.acceleration, spin,
                   1.5 * spin_rate - 0.5 * bone.spin_rate};
  }
  bone.mid_rotation = (bone.pose.rotation * turn_by(0.5 * step_ * spin)).toRotationMatrix();
}

void DrivenFrame::prepare(const Vector3d& gravity) {
  gravity_push_.setZero();
  push_.setZero();
  turning_ = false;
  for (Bone& bone : bones_) {
    find_motion(bone);
    const Vector3d g = bone.mid_rotation.transpose() * gravity;
    const Vector3d a = bone.mid_rotation.transpose() * bone.motion.acceleration;
    x_.noalias() = bone.inertia->s.transpose() * g;
    gravity_push_ += x_;
    push_.noalias() += bone.inertia->s.transpose() * (-a);
    push_ += x_;
    turning_ = turning_ || bone.turning();
  }
  turned_work_ = 0.0;
  if (turning_) {
    stiffness_.setZero();
    gyro_.setZero();
    for (const Bone& bone : bones_)
      if (bone.turning()) add_turn(bone);
  }
  push_norm_ = push_.norm();
}

Eigen::VectorXd DrivenFrame::gravity_force(const Vector3d& gravity) const {
  VectorXd force = VectorXd::Zero(push_.size());
  for (const Bone& bone : bones_)
    force += bone.inertia->s.transpose() * (bone.pose.rotation.conjugate() * gravity);
  return force;
}

// Adds the constant parts to push_, and the parts linear in q and v to stiffness_ and gyro_.
void DrivenFrame::add_turn(const Bone& bone) {
  const FrameInertia& inertia = *bone.inertia;
  const Vector3d& w = bone.motion.spin;
  const Vector3d& rate = bone.motion.spin_rate;
  const Vector3d whirl = -2.0 * w;
  // Weights of the blocks of `pairs`: c_x c_y c_z, and the six of sym(B).
  std::array<double, 9> weights = {-rate.x(), -rate.y(), -rate.z()};
  Eigen::Matrix<double, 6, 1> constant;
  for (Index e = 0; e < 6; ++e) {
    const auto& [k, l] = kSymmetricEntries[e];
    const double ww = w[k] * w[l] * (k == l ? 1.0 : 2.0);
    weights[3 + e] = ww;
    constant[e] = 0.5 * ((k == l ? w.squaredNorm() : 0.0) - ww);
  }
  // With one bone the traces of the B_ij are those of the identity.
  if (bones_.size() == 1) {
    stiffness_.diagonal().setConstant(-w.squaredNorm());
  } else {
    for (std::size_t e = 3; e < 6; ++e) weights[e] -= w.squaredNorm();
  }
  add_blocks(inertia.pairs, weights, stiffness_);
  add_blocks(inertia.pairs, {whirl.data(), 3}, gyro_);
  push_.noalias() -= inertia.a.transpose() * rate;
  push_.noalias() += inertia.P_linear * constant;
}

void DrivenFrame::half_turn(bool first, State& state) {
  const double h = step_;
  const auto gyro = gyro_.topRows(state.p.size());
  if (first) {
    turn_ = (0.25 * h) * gyro;
    turn_.diagonal().array() += 1.0;
    turn_factor_.compute(turn_);
  }
  const auto turn = [&] {
    x_ = state.p;
    x_.noalias() -= (0.25 * h) * gyro * state.p;
    state.p.noalias() = turn_factor_.solve(x_);
  };
  if (first) turn();
  const double before = state.p.squaredNorm();
  state.p.noalias() -= (0.5 * h) * stiffness_.topRows(state.q.size()) * state.q;
  turned_work_ += 0.5 * (state.p.squaredNorm() - before);
  if (!first) turn();
}

void DrivenFrame::begin(double h, const VectorXd& q0, const VectorXd&) {
  h_ = h;
  q0_ = q0;
}

void DrivenFrame::evaluate(const VectorXd& d, const VectorXd&, VectorXd&, VectorXd& force) {
  const Index r = d.size();
  x_ = q0_ + 0.5 * d;
  multiply_tall(stiffness_, r, x_, stiff_);
  multiply_tall(gyro_, r, d, whirl_);
  force += stiff_.head(r) + (1.0 / h_) * whirl_.head(r);
}

bool DrivenFrame::finish(const VectorXd& d, double, VectorXd&) {
  turned_work_ -= stiff_.head(d.size()).dot(d);
  return false;
}

void DrivenFrame::end_step(const VectorXd& q0, const VectorXd& q1) {
  x_ = q1 - q0;
  const double gravity = gravity_push_.dot(x_);
  gravity_work_ += gravity;
  support_work_ += push_.dot(x_) - gravity + turned_work_;
  for (Bone& bone : bones_) take_next(bone);
}

void DrivenFrame::take_next(Bone& bone) const {
  const Vector3d velocity = (bone.next.position - bone.pose.position) / step_;
  const Vector3d spin = spin_between(bone.pose, bone.next, step_);
  bone.acceleration = (velocity - bone.velocity) / step_;
  bone.spin_rate = (spin - bone.spin) / step_;
  bone.velocity = velocity;
  bone.spin = spin;
  bone.pose = bone.next;
  bone.known = false;
}

void DrivenFrame::start_parts() {
  whole_ = bones_;
}

void DrivenFrame::take_part(double from, double to) {
  turned_work_ = 0.0;
  for (std::size_t b = 0; b < bones_.size(); ++b) {
    const Pose &start = whole_[b].pose, &end = whole_[b].next;
    if (start.position == end.position && start.rotation.coeffs() == end.rotation.coeffs())
      continue;
    bones_[b].pose = pose_between(start, end, from);
    bones_[b].next = pose_between(start, end, to);
  }
}

void DrivenFrame::end_parts() {
  bones_ = whole_;
  turned_work_ = 0.0;
  for (Bone& bone : bones_) take_next(bone);
}

void DrivenFrame::cancel_step() {
  turned_work_ = 0.0;
}

}  // namespace tremolo
