#include "runtime/contact/solve/contact_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremolo {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Stiff coordinates keep the weight x cot x, also where they follow others: with their whole
// inertia vibrations of contact last longer, and a stack of stiff bodies needs twice the time to
// come to rest.
InertiaDamping contact_damping(const Model& model, const IntegratorOptions& options) {
  return make_inertia_damping(model, options, cotangent_weight, cotangent_weight);
}

}  // namespace

ContactStep::ContactStep(Model::Pointer model, const IntegratorOptions& options,
                         ContactSurface surface)
    : model_(std::move(model)),
      options_(options),
      eq_(std::move(surface), model_->modes()),
      damping_(contact_damping(*model_, options)),
      strain_(*model_, options.beta),
      rest_(VectorXd::Zero(model_->modes())),
      rest_middle_(rest_),
      workspace_(model_->potential().make_workspace(kUseSegment)) {
  const Index r = model_->modes(), n = r + 6;
  for (VectorXd* v : {&eq_.q0, &v0_, &eq_.q1, &G_, &dp_, &force_, &own_force_, &middle_,
                      &eq_.pushed, &slopes_at_})
    v->setZero(r);
  for (VectorXd* v : {&eq_.z, &known_z_, &z_before_, &eq_.residual, &move_}) v->setZero(n);
  if (eq_.surface.shape) eq_.u0 = eq_.u1 = VectorXd::Zero(eq_.points().axis_rows.rows());
  K_.setZero(r, r);
  eq_.jacobian.setIdentity(n, n);
  const Index own = eq_.surface.can_move ? n : r;
  factor_.compute(eq_.jacobian.topLeftCorner(own, own));
  eq_.motion.modes = r;
  use_options();
}

void ContactStep::set_options(const IntegratorOptions& options) {
  if (options.beta != options_.beta) strain_ = StrainDamping(*model_, options.beta);
  options_ = options;
  damping_ = contact_damping(*model_, options_);
  use_options();
}

// Updates all values that depend on the step and on damping_.
void ContactStep::use_options() {
  const Index r = model_->modes();
  const double h = eq_.motion.h = options_.step;
  S_ = (0.5 + h * damping_.theta.array() * damping_.D.array()).inverse();
  const double root = std::sqrt(surface().mass);
  eq_.row_scale.setConstant(r + 6, 2.0 / h);
  eq_.row_scale.segment<3>(r).setConstant(1.0 / (root * eq_.points().radius));
  eq_.row_scale.tail<3>().setConstant(h / root);
}

void ContactStep::reset() {
  record_.reset();
  memories_.clear();
  pair_memories_.clear();
}

void ContactStep::begin(const State& state, const StepLoad& load, FreeFrame* free) {
  const double h = options_.step;
  const Index r = model_->modes();
  load_ = &load;
  free_ = free;
  in_island_ = true;
  known_ = slopes_known_ = false;
  eq_.q0 = state.q;
  v0_ = state.p;
  rest_middle_ = eq_.q0 + (0.5 * h) * v0_;
  strain_.stand_at(rest_middle_);
  if (load.coupling != nullptr) load.coupling->begin(h, eq_.q0, v0_);
  eq_.motion.free = free_ != nullptr;
  eq_.motion.R0 = gathered_.poses.start.rotation.toRotationMatrix();
  eq_.motion.origin = free_ != nullptr ? free_->mesh_centre() : Vector3d(Vector3d::Zero());
  eq_.motion.c0 = free_ != nullptr ? free_->rigid().centre : gathered_.poses.start.position;
  eq_.z.head(r) = h * v0_;
  if (on_bones()) follow_bones();
  for (Candidate& candidate : touching()) begin_candidate(candidate);
  joints_rounding_ = joints_far_ = 0.0;
  first_size_ = -1.0;
  if (free_ != nullptr) {
    eq_.z.segment<3>(r) = free_->rigid().spin;
    eq_.z.tail<3>() = h * free_->rigid().velocity;
    return;
  }
  eq_.motion.follow(gathered_.poses);
}

// Sets the motions of contact points and grips by bones.
void ContactStep::follow_bones() {
  StepMotion fresh;
  fresh.h = options_.step;
  fresh.modes = model_->modes();
  fresh.origin.setZero();
  eq_.point_motions.assign(eq_.points().size(), fresh);
  for (std::size_t i = 0; i < eq_.point_motions.size(); ++i)
    eq_.point_motions[i].follow(eq_.bones->maps(i).start, eq_.bones->maps(i).end);
  grip_motions_.assign(grips_.size(), fresh);
  for (std::size_t i = 0; i < grips_.size(); ++i)
    grip_motions_[i].follow(grip_maps_[i].start, grip_maps_[i].end);
}

// A spring's mean force is its force at the middle of the step, which is exactly its discrete
// gradient.
void ContactStep::add_grips() {
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    Grip& grip = grips_[i];
    ContactTouch& touch = held_[i];
    touch = eq_.touch_at(motion_of_grip(i), grip.place.rest, place_rows(grip.place));
    const Vector3d from = touch.x0 - grip.start, to = touch.x1 - grip.end;
    grip.force =
        (-0.5 * grip.stiffness) * (from + to) - (grip.damping / options_.step) * (to - from);
    eq_.push(motion_of_grip(i), grip.force, grip.force, touch, place_rows(grip.place));
  }
}

// The rotation of the body relative to a collider in the step, along the collider's axes, rad.
Vector3d ContactStep::turn_along(const ColliderTurns& turns, const PlacedCollider& collider) const {
  return turns.mean.transpose() * eq_.motion.turn_in_step() -
         turn_of(collider.start.rotation.conjugate() * collider.end.rotation);
}

// From a round point to the surface, m, world.
Vector3d ContactStep::surface_of(const Candidate& candidate) const {
  return turns_[candidate.collider].mean * surface_arm(candidate.law, candidate.held);
}

void ContactStep::add_contact(const ContactRenewal& renewal) {
  eq_.clear_forces();
  std::fill(rates_.begin(), rates_.end(), PairRate{});
  for (Candidate& candidate : touching()) {
    candidate.touch = eq_.motion_of(candidate.point)
                          .touch(candidate.y0, eq_.place_in_body(candidate.point, eq_.q1));
    candidate.end = contact_end(candidate.law, gathered_.colliders[candidate.collider],
                                turns_[candidate.collider], candidate.start, candidate.touch.x1);
    if (candidate.law.radius > 0.0)
      candidate.end.turn =
          turn_along(turns_[candidate.collider], gathered_.colliders[candidate.collider]);
    const ContactGap& gap = candidate.end.gap;
    rates_[candidate.collider].add(gap.pressure, gap.d1 - gap.d0);
  }
  for (Candidate& candidate : touching()) {
    candidate.now =
        contact_force(candidate.law, gathered_.colliders[candidate.collider],
                      turns_[candidate.collider], candidate.start, candidate.memory, candidate.end,
                      time_with(candidate.collider), renewal, candidate.held);
    if (candidate.now.acts) eq_.push_point(candidate.now.force, candidate.touch, candidate.point);
    if (candidate.now.acts && candidate.law.radius > 0.0)
      eq_.push_turn(surface_of(candidate).cross(candidate.now.rub));
  }
  add_grips();
}

void ContactStep::evaluate(const ContactRenewal& renewal) {
  // Between a trial and a renewal only the contact changes.
  if (!known_ || eq_.z != known_z_) evaluate_body();
  add_contact(renewal);
}

// All parts that depend on z_, except forces at positions.
void ContactStep::evaluate_body() {
  const double h = options_.step;
  const Index r = model_->modes();
  const auto d = eq_.z.head(r);
  known_ = true;
  known_z_ = eq_.z;
  eq_.q1 = eq_.q0 + d;
  if (in_island_ && eq_.surface.shape) eq_.points().displacement(eq_.q1, eq_.u1);
  model_->potential().averaged_gradient(eq_.q0, eq_.q1, workspace_, G_, nullptr);
  dp_ = S_.cwiseProduct(damping_.n.cwiseProduct(d) / h - v0_);
  own_force_ = G_ - load_->average;
  middle_ = d;
  rest_work_ = 0.0;
  if (strain_.present()) {
    rest_middle_ = eq_.q0 + 0.5 * middle_;
    rest_work_ = strain_.force(rest_middle_, middle_, rest_) / h;
    own_force_ += rest_ / h;
  }
  if (free_ != nullptr) {
    const FreeFrame::SpinTrial trial =
        free_->try_spin(middle_, S_, eq_.z.segment<3>(r), dp_, own_force_);
    spin_jacobian_ = trial.jacobian;
    eq_.motion.set_turn(trial.turn);
    const Vector3d phi = (0.5 * h) * (free_->rigid().spin + eq_.z.segment<3>(r));
    eq_.motion.phi = phi;
    eq_.motion.turned = (0.5 * h / (1.0 + 0.25 * phi.squaredNorm())) *
                        (Matrix3d::Identity() - 0.5 * cross_matrix(phi));
    own_spin_residual_ = trial.residual;
    own_centre_residual_ = free_->centre_residual(eq_.z.tail<3>());
    eq_.motion.c1 = eq_.motion.c0 + eq_.z.tail<3>();
  } else if (load_->coupling != nullptr) {
    load_->coupling->evaluate(middle_, S_, dp_, own_force_);
  }
}

StepWay ContactStep::way_in_step() const {
  const double bend = eq_.bend_in_step();
  if (on_bones()) return {bend, std::numeric_limits<double>::infinity(), 0.0};
  const StepMotion& motion = eq_.motion;
  const ContactBall& ball = gathered_.ball;
  // Two singular values of the difference of two rotations are equal, and the third is zero.
  const double turn = (motion.R1 - motion.R0).norm() / std::numbers::sqrt2;
  const double far = (ball.centre - motion.c0).norm() + ball.radius + ball.deformed;
  return {bend, (motion.c1 - motion.c0).norm() + turn * far + bend, turn};
}

// The size of the residual without the forces at positions.
double ContactStep::size_without_contact() {
  const double h = options_.step;
  const Index r = model_->modes();
  eq_.residual.head(r) = (0.5 * h) * damping_.n.cwiseProduct(dp_) + (0.5 * h * h) * own_force_ +
                         (0.5 * h) * damping_.D.cwiseProduct(eq_.z.head(r));
  if (free_ != nullptr) {
    eq_.residual.segment<3>(r) = own_spin_residual_;
    eq_.residual.tail<3>() = own_centre_residual_;
  }
  return eq_.size_of_residual();
}

double ContactStep::close() {
  const double h = options_.step;
  const Index r = model_->modes();
  if (first_size_ < 0.0) first_size_ = size_without_contact();
  force_ = own_force_ - eq_.pushed;
  eq_.residual.head(r) = (0.5 * h) * damping_.n.cwiseProduct(dp_) + (0.5 * h * h) * force_ +
                         (0.5 * h) * damping_.D.cwiseProduct(eq_.z.head(r));
  if (free_ != nullptr) {
    eq_.residual.segment<3>(r) =
        own_spin_residual_ - h * (eq_.motion.turn.transpose() * eq_.torque);
    eq_.residual.tail<3>() = own_centre_residual_ - eq_.force;
  }
  return eq_.size_of_residual();
}

void ContactStep::add_contact_slopes(bool follows) {
  const Index n = eq_.unknowns();
  const auto pushes = [this](std::size_t collider) { return rates_[collider].force > 0.0; };
  for (std::size_t c = 0; c < rates_.size(); ++c) {
    if (!pushes(c)) continue;
    taken_push_.col(static_cast<Index>(c)).setZero();
    taken_growth_.col(static_cast<Index>(c)).setZero();
  }
  for (const Candidate& candidate : touching()) {
    if (!candidate.now.acts) continue;
    eq_.lever.make(eq_.motion_of(candidate.point), candidate.touch,
                   eq_.point_rows(candidate.point));
    const PlacedSlope slope =
        contact_slope(candidate.law, turns_[candidate.collider], candidate.start, candidate.end,
                      time_with(candidate.collider), candidate.held, follows);
    eq_.lever.add_tangent(slope.by_end, eq_.jacobian);
    eq_.add_geometry_at_point(candidate.now.force, candidate.touch, candidate.point);
    if (candidate.law.radius > 0.0) add_roll_slopes(candidate, slope);
    if (!pushes(candidate.collider)) continue;
    const auto column = static_cast<Index>(candidate.collider);
    taken_push_.col(column).head(n).noalias() += eq_.lever.push().lazyProduct(slope.by_taken);
    taken_growth_.col(column).head(n).noalias() +=
        eq_.lever.way().transpose().lazyProduct(slope.taken);
  }
  for (std::size_t c = 0; c < rates_.size(); ++c) {
    if (!pushes(c)) continue;
    const auto column = static_cast<Index>(c);
    eq_.jacobian.topLeftCorner(n, n).noalias() +=
        taken_push_.col(column).head(n).lazyProduct(taken_growth_.col(column).head(n).transpose());
  }
}

// The parts that a round point has in addition: the surface's path, and the torque of friction.
void ContactStep::add_roll_slopes(const Candidate& candidate, const PlacedSlope& slope) {
  const Index n = eq_.unknowns();
  const Vector3d arm = surface_of(candidate);
  const Matrix3d lever = cross_matrix(arm);
  const Eigen::Matrix3Xd by_turn = slope.by_roll * eq_.roll_slopes(arm);
  const Eigen::Matrix3Xd by_end = slope.rub_by_end * eq_.lever.way();
  eq_.jacobian.topLeftCorner(n, n).noalias() += eq_.lever.push() * by_turn;
  eq_.add_turn_slopes(lever * (by_turn + by_end), eq_.own_block());
  eq_.add_turn_geometry(arm.cross(candidate.now.rub));
  const auto column = static_cast<Index>(candidate.collider);
  if (rates_[candidate.collider].force > 0.0)
    eq_.add_turn_slopes(lever * slope.rub_by_taken, taken_push_.col(column).head(n));
}

// K_, unless that of an earlier move in the step is as good: the moves contract by its error.
void ContactStep::make_slopes() {
  constexpr double kSameSlopes = 1e-3;  // of the body's radius
  const ContactPoints& points = eq_.points();
  if (slopes_known_ &&
      (eq_.q1 - slopes_at_).cwiseAbs().dot(points.reach) <= kSameSlopes * points.radius)
    return;
  model_->potential().averaged_jacobian(eq_.q0, eq_.q1, workspace_, K_);
  slopes_at_ = eq_.q1;
  slopes_known_ = true;
}

// The Jacobian of the residual of evaluate(), without the gyroscopic terms of a rotating frame,
// which are of a higher order in h.
void ContactStep::make_jacobian(double heavier, bool follows) {
  const double h = options_.step;
  const Index r = model_->modes();
  const VectorXd& n = damping_.n;
  make_slopes();
  eq_.jacobian.setZero();
  eq_.jacobian.topLeftCorner(r, r) = (0.5 * h * h + h * strain_.beta()) * K_;
  if (strain_.present())
    eq_.jacobian.topLeftCorner(r, r).diagonal() -= (0.5 * h * strain_.beta()) * model_->lambda();
  eq_.jacobian.topLeftCorner(r, r).diagonal() +=
      ((0.5 + 0.5 * heavier) * n.array().square() * S_.array() + 0.5 * h * damping_.D.array())
          .matrix();
  if (free_ != nullptr) {
    const Eigen::Matrix3Xd& C1 = free_->end_coupling();
    for (Index j = 0; j < r; ++j) {
      eq_.jacobian.block<1, 3>(j, r) = (0.25 * h * n[j] * S_[j]) * C1.col(j).transpose();
      eq_.jacobian.block<3, 1>(r, j) = (S_[j] * n[j] / h) * C1.col(j);
    }
    eq_.jacobian.block<3, 3>(r, r) = (1.0 + heavier) * spin_jacobian_;
    eq_.jacobian.bottomRightCorner<3, 3>().diagonal().setConstant((1.0 + heavier) * 2.0 *
                                                                  surface().mass / (h * h));
  }
  add_contact_slopes(follows);
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const double stiffness = 0.5 * grips_[i].stiffness + grips_[i].damping / h;
    const PlaceRows rows = place_rows(grips_[i].place);
    eq_.lever.make(motion_of_grip(i), held_[i], rows);
    eq_.lever.add_tangent(stiffness * Matrix3d::Identity(), eq_.jacobian);
    if (free_ == nullptr) continue;
    eq_.lever.make_swing(eq_.motion, held_[i], rows);
    eq_.add_geometry(grips_[i].force, grips_[i].force, held_[i], rows);
  }
}

}  // namespace tremolo
