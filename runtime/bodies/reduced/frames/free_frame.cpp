#include "runtime/bodies/reduced/frames/free_frame.h"

#include <limits>
#include <utility>

#include <Eigen/LU>

#include "runtime/math/dense/small_matrices.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kSpinIterations = 12;  // of Newton's method; two are usual
// A shorter move, relative to omega1, is below rounding: the next would be about its square.
constexpr double kLastMove = 1e-9;
// The same relative to the momenta of the equation, which may cancel in omega1. What a longer move
// leaves is no rounding.
constexpr double kSmallMove = 1e-7;

}  // namespace

FreeFrame::FreeFrame(std::shared_ptr<const FrameInertia> inertia)
    : inertia_(std::move(inertia)),
      at0_(inertia_->modes()),
      at1_(inertia_->modes()),
      scratch_(inertia_->modes()) {
  const Index r = inertia_->modes();
  for (VectorXd* v : {&q0_, &q1_, &v0_, &v1_, &m_, &kick0_, &kappa_, &added_}) v->setZero(r);
  bend0_.setZero(tall_rows(3 * r));
  bend1_.setZero(tall_rows(3 * r));
  rigid_.centre = inertia_->centre;
}

Pose FreeFrame::pose() const {
  return {rigid_.centre - rigid_.rotation * inertia_->centre, rigid_.rotation};
}

void FreeFrame::set_pose(const Pose& pose, const VectorXd& q, const VectorXd& v) {
  rigid_.rotation = pose.rotation;
  rigid_.centre = pose * inertia_->centre;
  rigid_.centre_rest.setZero();
  set_motion(rigid_.velocity, rigid_.spin, q, v);
}

void FreeFrame::set_motion(const Vector3d& velocity, const Vector3d& spin, const VectorXd& q,
                           const VectorXd& v) {
  scratch_.compute(*inertia_, q);
  rigid_.velocity = velocity;
  rigid_.spin = spin;
  rigid_.momentum = rigid_.rotation * (scratch_.J * spin + scratch_.C * v);
}

double FreeFrame::kinetic(const VectorXd& q, const VectorXd& v) const {
  scratch_.compute(*inertia_, q);
  const Vector3d& spin = rigid_.spin;
  return 0.5 * inertia_->mass * rigid_.velocity.squaredNorm() + 0.5 * spin.dot(scratch_.J * spin) +
         spin.dot(scratch_.C * v) + 0.5 * v.squaredNorm();
}

void FreeFrame::prepare(std::span<const StepForce> forces, const Vector3d& gravity) {
  forces_ = forces;
  gravity_ = gravity;
  if (arms_.size() < forces.size()) {
    arms_.resize(forces.size());
    pulls_.resize(forces.size());
  }
  load_work_ = gravity_work_ = 0.0;
  set_contact(Vector3d::Zero(), Vector3d::Zero());
}

void FreeFrame::begin(double h, const VectorXd& q0, const VectorXd& v0) {
  const Index r = inertia_->modes();
  h_ = h;
  q0_ = q0;
  v0_ = v0;
  if (at_end_ && q1_ == q0_)
    std::swap(at0_, at1_);
  else
    at0_.compute(*inertia_, q0_);
  at_end_ = false;
  kick0_.noalias() = at0_.C.transpose() * rigid_.spin;
  multiply_tall(inertia_->pairs, 3 * r, v0_, bend0_);
  momentum0_ = rigid_.rotation.conjugate() * rigid_.momentum;
  spin1_ = rigid_.spin;
  torque_.setZero();
  total_force_.setZero();
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    pulls_[i] = rigid_.rotation.conjugate() * forces_[i].force;
    total_force_ += forces_[i].force;
  }
}

// Torque of the forces, along the body's axes at the start, N m. mean_turn: Ro0^T Ro~.
Vector3d FreeFrame::torque(const Matrix3d& mean_turn) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < forces_.size(); ++i) sum += (mean_turn * arms_[i]).cross(pulls_[i]);
  return sum;
}

// J1 w + C1 v1 - Ro1^T l1 with v1 = v0 + dp - (1 - S/2) (C1^T w - C0^T omega0): `inertia` is J1
// less the part that v1 takes of it, `coupled` the rest of C1 v1.
FreeFrame::SpinTrial FreeFrame::spin_equation(const Matrix3d& inertia, const Vector3d& coupled,
                                              const Vector3d& w) {
  const Vector3d phi = (0.5 * h_) * (rigid_.spin + w);
  SpinTrial trial;
  trial.turn = cayley_matrix(phi);
  torque_ = contact_torque_;
  if (!forces_.empty()) torque_ += torque(0.5 * (Matrix3d::Identity() + trial.turn));
  const Vector3d l1 = momentum0_ + h_ * torque_;
  momentum1_ = trial.turn.transpose() * l1;
  // (1 + [phi]/2)^-1 = (1 + turn^T)/2.
  const Matrix3d half = 0.5 * (Matrix3d::Identity() + trial.turn.transpose());
  trial.jacobian = inertia - (0.25 * h_) * half * cross_matrix(momentum1_ + l1);
  trial.residual = inertia * w + coupled - momentum1_;
  return trial;
}

// Returns the inertia of spin_equation(), and sets v1 without omega1's contribution.
Matrix3d FreeFrame::begin_spin(const VectorXd& S, const VectorXd& dp) {
  kappa_ = 1.0 - 0.5 * S.array();  // theta h D S
  Matrix3d inertia = at1_.J;
  v1_ = v0_ + dp;
  // Without damping omega1 contributes nothing to v1.
  if (kappa_.isZero(0.0)) return inertia;
  for (Index j = 0; j < S.size(); ++j)
    inertia -= kappa_[j] * at1_.C.col(j) * at1_.C.col(j).transpose();
  v1_ += kappa_.cwiseProduct(kick0_);
  return inertia;
}

// Sets v1 and kappa from omega1.
void FreeFrame::end_spin(const VectorXd& S, const VectorXd& dp) {
  kappa_.noalias() = at1_.C.transpose() * spin1_;
  kappa_ -= kick0_;
  v1_ = v0_ + dp - (1.0 - 0.5 * S.array()).matrix().cwiseProduct(kappa_);
}

// Finds omega1 by Newton's method to rounding. It may fail for a body that turns by several radians
// in a step.
void FreeFrame::find_spin(const VectorXd& S, const VectorXd& dp) {
  const Matrix3d inertia = begin_spin(S, dp);
  const Vector3d coupled = at1_.C * v1_;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSpinIterations; ++i) {
    const SpinTrial trial = spin_equation(inertia, coupled, spin1_);
    const Matrix3d inverse = trial.jacobian.inverse();
    const Vector3d move = -(inverse * trial.residual);
    spin1_ += move;
    const double size = move.norm();
    const bool small = size <= kSmallMove * inverse.norm() * (momentum1_.norm() + coupled.norm());
    unsolved_ = small ? 0.0 : trial.residual.norm();
    // At rounding level the moves no longer shrink.
    if (size <= kLastMove * spin1_.norm() || (small && size >= last)) break;
    last = size;
  }
  end_spin(S, dp);
}

FreeFrame::SpinTrial FreeFrame::try_spin(const VectorXd& d, const VectorXd& S, const Vector3d& w,
                                         VectorXd& dp, VectorXd& force) {
  set_end(d);
  const Matrix3d inertia = begin_spin(S, dp);
  const Vector3d coupled = at1_.C * v1_;
  spin1_ = w;
  const SpinTrial trial = spin_equation(inertia, coupled, w);
  end_spin(S, dp);
  add_forces(dp, force);
  return trial;
}

Vector3d FreeFrame::centre_residual(const Vector3d& e) const {
  return (2.0 * inertia_->mass / h_) * (e / h_ - rigid_.velocity) - total_force_ -
         inertia_->mass * gravity_;
}

void FreeFrame::set_contact(const Vector3d& force, const Vector3d& torque) {
  contact_force_ = force;
  contact_torque_ = torque;
}

void FreeFrame::set_end(const VectorXd& d) {
  q1_ = q0_ + d;
  at1_.compute(*inertia_, q1_);
  at_end_ = true;
  m_ = q0_ + 0.5 * d;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const VertexRows& place = *forces_[i].place;
    arms_[i] = place.rest - inertia_->centre;
    arms_[i].noalias() += place.rows * m_;
  }
}

void FreeFrame::evaluate(const VectorXd& d, const VectorXd& S, VectorXd& dp, VectorXd& force) {
  set_end(d);
  find_spin(S, dp);
  add_forces(dp, force);
}

// The change of p, and g and the forces of prepare(), from v1 and omega1.
void FreeFrame::add_forces(VectorXd& dp, VectorXd& force) {
  const Index r = inertia_->modes();
  dp = v1_ - v0_ + kappa_;
  const Vector3d& w0 = rigid_.spin;
  multiply_tall(inertia_->pairs, 3 * r, v1_, bend1_);
  added_.setZero();
  for (Index m = 0; m < 3; ++m)
    added_ -= 0.5 * (w0[m] * bend1_.segment(m * r, r) + spin1_[m] * bend0_.segment(m * r, r));
  const double w0w1 = w0.dot(spin1_);
  for (Index e = 0; e < 6; ++e) {
    const auto& [k, l] = kSymmetricEntries[e];
    const double weight =
        k == l ? w0w1 - w0[k] * spin1_[k] : -(w0[k] * spin1_[l] + w0[l] * spin1_[k]);
    // d_jP at the middle is linear in q: the products of both ends added up.
    added_ -= (0.5 * weight) * (inertia_->P_linear.col(e) + at0_.products.segment((3 + e) * r, r) +
                                at1_.products.segment((3 + e) * r, r));
  }
  if (!forces_.empty()) {
    const Matrix3d mean = 0.5 * (Matrix3d::Identity() + cayley_matrix((0.5 * h_) * (w0 + spin1_)));
    for (std::size_t i = 0; i < forces_.size(); ++i)
      added_.noalias() -= forces_[i].place->rows.transpose() * (mean.transpose() * pulls_[i]);
  }
  force += added_;
  force_norm_ = added_.norm();
}

bool FreeFrame::finish(const VectorXd& d, double defect, VectorXd& v) {
  // Along v with constant l and Ro1, T changes as the square of v's length in the metric 1 - C^T
  // J^-1 C.
  const Matrix3d inverse = at1_.J.inverse();
  const Vector3d coupled = at1_.C * v1_;
  give_back(defect, 0.5 * (v1_.squaredNorm() - coupled.dot(inverse * coupled)), v1_);
  const Vector3d mean_spin = 0.5 * (rigid_.spin + spin1_);
  if (!forces_.empty()) {
    const Matrix3d mean = 0.5 * (Matrix3d::Identity() + cayley_matrix(h_ * mean_spin));
    load_work_ += h_ * (torque_ - contact_torque_).dot(mean_spin);
    for (std::size_t i = 0; i < forces_.size(); ++i)
      load_work_ += (mean * (forces_[i].place->rows * d)).dot(pulls_[i]);
  }
  if (!torque_.isZero(0.0)) rigid_.momentum += h_ * (rigid_.rotation * torque_);
  rigid_.rotation = (rigid_.rotation * cayley(h_ * mean_spin)).normalized();
  momentum1_ = rigid_.rotation.conjugate() * rigid_.momentum;
  rigid_.spin = inverse * (momentum1_ - at1_.C * v1_);
  move_centre();
  v = v1_;
  return true;
}

void FreeFrame::move_centre() {
  const Vector3d before = rigid_.velocity;
  rigid_.velocity += h_ * ((total_force_ + contact_force_) / inertia_->mass + gravity_);
  const Vector3d path = (0.5 * h_) * (before + rigid_.velocity);
  // Kahan's sum: the rounding errors of a long flight would otherwise show in the angular momentum.
  const Vector3d rest = rigid_.centre_rest + path;
  const Vector3d next = rigid_.centre + rest;
  rigid_.centre_rest = rest - (next - rigid_.centre);
  rigid_.centre = next;
  load_work_ += total_force_.dot(path);
  gravity_work_ += inertia_->mass * gravity_.dot(path);
}

}  // namespace tremolo
