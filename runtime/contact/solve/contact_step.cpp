#include "runtime/contact/solve/contact_step.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/solve/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kNewtonIterations = 100;  // Newton's, with the line search
constexpr int kShorter = 12;            // halvings of a move
constexpr int kRenewals = 20;           // iterations in which normals and friction are renewed,
constexpr int kFullRenewals = 6;        // of them not by halves,
constexpr double kHeldBelow = 1e6;      // unless the residual is below so many times what is small
constexpr double kRoundedWay = 1e-14;   // of the body's extent

// How far any point of a ball of `radius` about `place` moves in the world between the poses, m.
double reach_of(const StepPoses& poses, const Vector3d& place, double radius) {
  const double angle = turn_of(poses.start.rotation.conjugate() * poses.end.rotation).norm();
  return (poses.end * place - poses.start * place).norm() + angle * radius;
}

}  // namespace

ContactStep::ContactStep(Model::Pointer model, const IntegratorOptions& options,
                         const ContactOptions& contact, double mass, bool free)
    : model_(std::move(model)),
      options_(options),
      points_(std::make_shared<const ContactPoints>(
          choose_contact_points(*model_, static_cast<std::size_t>(contact.points)))),
      mass_(mass),
      can_move_(free),
      feels_(contact.colliders),
      shape_(contact.shape),
      damping_(make_inertia_damping(*model_, options, cotangent_weight)),
      strain_(*model_, options.beta),
      rest_(Eigen::VectorXd::Zero(model_->modes())),
      rest_middle_(rest_),
      S_((0.5 + options.step * damping_.theta.array() * damping_.D.array()).inverse()),
      workspace_(model_->potential().make_workspace(kUseSegment)),
      lever_(model_->modes()) {
  const double h = options.step;
  law_.margin = contact.margin * points_->extent;
  law_.stiffness = contact.stiffness * mass / (2.0 * h * h * law_.margin);
  law_.friction = contact.friction;
  law_.restitution = contact.restitution;
  law_.rebound_speed = 0.01 * law_.margin / h;
  law_.slip_speed = 0.01 * law_.margin / h;
  const Index r = model_->modes(), n = r + 6;
  for (VectorXd* v : {&q0_, &v0_, &q1_, &G_, &dp_, &force_, &own_force_, &middle_, &contact_push_})
    v->setZero(r);
  for (VectorXd* v : {&z_, &known_z_, &z_before_, &residual_, &move_}) v->setZero(n);
  scale_rows();
  if (shape_) u0_ = u1_ = VectorXd::Zero(points_->axis_rows.rows());
  K_.setZero(r, r);
  jacobian_.setIdentity(n, n);
  factor_.compute(jacobian_.topLeftCorner(free ? n : r, free ? n : r));
  motion_.h = h;
  motion_.modes = r;
}

void ContactStep::reset() {
  const double left = account_.energy;
  account_ = {};
  account_.surplus = -left;
  std::fill(impulses_.begin(), impulses_.end(), 0.0);
}

bool ContactStep::gather(std::span<const PlacedCollider> colliders, const StepPoses& poses,
                         const VectorXd& q, const VectorXd& v) {
  if (!kHasColliders || !feels_) colliders = {};
  colliders_ = colliders;
  poses_ = poses;
  candidates_.clear();
  candidates_.reserve(points_->size() * colliders.size());
  impulses_.resize(colliders.size());
  q0_ = q;
  if (shape_) points_->displacement(q, u0_);
  // What the coordinates move a point by: so far, and in the step.
  ball_.centre = poses.start * points_->centre;
  ball_.radius = points_->radius;
  ball_.deformed = q.cwiseAbs().dot(points_->reach);
  ball_.travel = options_.step * v.cwiseAbs().dot(points_->reach) +
                 reach_of(poses, points_->centre, ball_.radius + ball_.deformed);
  for (std::size_t c = 0; c < colliders.size(); ++c) {
    const PlacedCollider& collider = colliders[c];
    const Vector3d centre = ball_.centre;
    const double radius = ball_.radius + ball_.deformed;
    // The collider's own motion, of what is near the body.
    const StepPoses its{collider.start, collider.end};
    const Vector3d local = collider.start.rotation.conjugate() * (centre - collider.start.position);
    // Twice: contact may speed a point up.
    const double reach = law_.margin + 2.0 * (ball_.travel + reach_of(its, local, radius));
    if (signed_distance(collider.shape, local).distance > radius + reach) continue;
    add_candidates(collider, c, q, reach);
  }
  held_.resize(grips_.size());
  return !touching().empty() || !grips_.empty();
}

void ContactStep::add_candidates(const PlacedCollider& collider, std::size_t index,
                                 const VectorXd& q, double reach) {
  ContactLaw law = law_;
  law.friction = collider.friction;
  law.restitution = collider.restitution;
  const double deformed = q.cwiseAbs().dot(points_->reach);
  const auto into = [&collider](const Vector3d& x) {
    return Vector3d(collider.start.rotation.conjugate() * (x - collider.start.position));
  };
  for (const PointGroup& group : points_->groups) {
    const Vector3d centre = into(poses_.start * group.centre);
    if (signed_distance(collider.shape, centre).distance > group.radius + deformed + reach)
      continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      Candidate candidate{i, index, law, Vector3d::Zero(), {}, {}, {}, {}};
      candidate.start = contact_start(law, collider, poses_.start * points_->place(i, q));
      candidate.held.normal = candidate.start.normal;
      if (candidate.start.distance <= reach) candidates_.push_back(candidate);
    }
  }
}

void ContactStep::begin(const State& state, const StepLoad& load, FreeFrame* free) {
  const double h = options_.step;
  const Index r = model_->modes();
  load_ = &load;
  free_ = free;
  in_island_ = true;
  known_ = false;
  q0_ = state.q;
  v0_ = state.p;
  rest_middle_ = q0_ + (0.5 * h) * v0_;
  strain_.stand_at(rest_middle_);
  if (load.coupling != nullptr) load.coupling->begin(h, q0_, v0_);
  motion_.free = free_ != nullptr;
  motion_.R0 = poses_.start.rotation.toRotationMatrix();
  motion_.origin = free_ != nullptr ? free_->mesh_centre() : Vector3d(Vector3d::Zero());
  motion_.c0 = free_ != nullptr ? free_->rigid().centre : poses_.start.position;
  z_.head(r) = h * v0_;
  for (Candidate& candidate : touching()) {
    candidate.held = {candidate.start.normal};
    candidate.y0 = place_in_body(candidate.point, q0_);
  }
  pairs_ = {};
  pairs_start_ = 0.0;
  joints_rounding_ = 0.0;
  if (free_ != nullptr) {
    z_.segment<3>(r) = free_->rigid().spin;
    z_.tail<3>() = h * free_->rigid().velocity;
    return;
  }
  motion_.set_turn(motion_.R0.transpose() * poses_.end.rotation.toRotationMatrix());
  const Eigen::Quaterniond turn = poses_.start.rotation.conjugate() * poses_.end.rotation;
  motion_.phi = 2.0 / turn.w() * turn.vec();
  motion_.c1 = poses_.end.position;
}

// rest: in the mesh's coordinates, m.
ContactTouch ContactStep::touch_at(const Vector3d& rest, const PlaceRows& rows) const {
  const Vector3d from = rest - motion_.origin;
  return motion_.touch(from + rows.transpose() * q0_, from + rows.transpose() * q1_);
}

// From c along the body's axes.
Vector3d ContactStep::place_in_body(std::size_t point, const VectorXd& q) const {
  const Vector3d from = points_->rest[point] - motion_.origin;
  return from + point_rows(point).transpose() * q;
}

ContactTouch ContactStep::touch_at_point(std::size_t point) const {
  return motion_.touch(place_in_body(point, q0_), place_in_body(point, q1_));
}

ContactTouch ContactStep::straight_touch_at(const VertexRows& place) const {
  const Vector3d from = place.rest - motion_.origin;
  return motion_.straight_touch(from + place.rows * q0_, from + place.rows * q1_);
}

Vector3d ContactStep::end_of_point(std::size_t point) const {
  return motion_.c1 + motion_.R1 * place_in_body(point, q1_);
}

Vector3d ContactStep::bend_under(const PlaceRows& rows) const {
  return motion_.turn_out(rows.transpose() * z_.head(model_->modes()));
}

void ContactStep::push(const Vector3d& force, const Vector3d& bend_force, const ContactTouch& touch,
                       const PlaceRows& rows) {
  contact_push_.noalias() +=
      rows * (motion_.mean.transpose() * (motion_.R0.transpose() * bend_force));
  contact_force_ += force;
  contact_torque_ += touch.arm.cross(motion_.R0.transpose() * force);
}

void ContactStep::push_point(const Vector3d& force, const ContactTouch& touch, std::size_t point) {
  push(force, force, touch, point_rows(point));
}

void ContactStep::push_turn(const Vector3d& torque) {
  contact_torque_ += motion_.R0.transpose() * torque;
}

// A spring's mean force is that at the middle of the step, and exactly its discrete gradient.
void ContactStep::add_grips() {
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    Grip& grip = grips_[i];
    ContactTouch& touch = held_[i];
    touch = touch_at(grip.place.rest, place_rows(grip.place));
    const Vector3d from = touch.x0 - grip.start, to = touch.x1 - grip.end;
    grip.force =
        (-0.5 * grip.stiffness) * (from + to) - (grip.damping / options_.step) * (to - from);
    push(grip.force, grip.force, touch, place_rows(grip.place));
  }
}

void ContactStep::add_contact(double renew) {
  contact_force_.setZero();
  contact_torque_.setZero();
  contact_push_.setZero();
  for (Candidate& candidate : touching()) {
    candidate.touch = motion_.touch(candidate.y0, place_in_body(candidate.point, q1_));
    candidate.now = contact_force(candidate.law, colliders_[candidate.collider], candidate.start,
                                  candidate.touch.x1, options_.step, renew, candidate.held);
    if (candidate.now.acts) push_point(candidate.now.force, candidate.touch, candidate.point);
  }
  add_grips();
}

// On a place of the body's own, on which the force is `force`.
void ContactStep::add_geometry(const Vector3d& force, const Vector3d& bend_force,
                               const ContactTouch& touch, const PlaceRows& rows) {
  if (free_ == nullptr) return;
  add_turn(motion_, force, bend_force, touch, rows, jacobian_);
  jacobian_.block(model_->modes(), 0, 3, unknowns()).noalias() +=
      motion_.turn_of_arm(force) * lever_.swing();
}

void ContactStep::add_geometry_at_point(const Vector3d& force, const ContactTouch& touch,
                                        std::size_t point) {
  if (free_ == nullptr) return;
  lever_.make_swing(motion_, touch, point_rows(point));
  add_geometry(force, force, touch, point_rows(point));
}

void ContactStep::add_geometry_of_other(const Vector3d& force, const Vector3d& bend_force,
                                        const ContactTouch& touch, const PlaceRows& rows) {
  if (free_ == nullptr) return;
  const Index r = model_->modes();
  add_turn(motion_, force, bend_force, touch, rows, jacobian_);
  jacobian_.block<3, 3>(r, r + 3) -= 0.5 * motion_.turn_of_arm(force) * motion_.R0.transpose();
}

void ContactStep::evaluate(double renew) {
  // Between a trial and a renewal only the contact changes.
  if (!known_ || z_ != known_z_) evaluate_body();
  add_contact(renew);
}

// All that depends on z_ but the forces on places.
void ContactStep::evaluate_body() {
  const double h = options_.step;
  const Index r = model_->modes();
  const auto d = z_.head(r);
  known_ = true;
  known_z_ = z_;
  q1_ = q0_ + d;
  if (in_island_ && shape_) points_->displacement(q1_, u1_);
  model_->potential().averaged_gradient(q0_, q1_, workspace_, G_, nullptr);
  dp_ = S_.cwiseProduct(damping_.n.cwiseProduct(d) / h - v0_);
  own_force_ = G_ - load_->average;
  middle_ = d;
  if (strain_.present()) {
    rest_middle_ = q0_ + 0.5 * middle_;
    rest_work_ = strain_.force(rest_middle_, middle_, rest_) / h;
    own_force_ += rest_ / h;
  }
  if (free_ != nullptr) {
    const FreeFrame::SpinTrial trial =
        free_->try_spin(middle_, S_, z_.segment<3>(r), dp_, own_force_);
    spin_jacobian_ = trial.jacobian;
    motion_.set_turn(trial.turn);
    const Vector3d phi = (0.5 * h) * (free_->rigid().spin + z_.segment<3>(r));
    motion_.phi = phi;
    motion_.turned = (0.5 * h / (1.0 + 0.25 * phi.squaredNorm())) *
                     (Matrix3d::Identity() - 0.5 * cross_matrix(phi));
    own_spin_residual_ = trial.residual;
    own_centre_residual_ = free_->centre_residual(z_.tail<3>());
    motion_.c1 = motion_.c0 + z_.tail<3>();
  } else if (load_->coupling != nullptr) {
    load_->coupling->evaluate(middle_, S_, dp_, own_force_);
  }
}

double ContactStep::close() {
  const double h = options_.step;
  const Index r = model_->modes();
  force_ = own_force_ - contact_push_;
  residual_.head(r) = (0.5 * h) * damping_.n.cwiseProduct(dp_) + (0.5 * h * h) * force_ +
                      (0.5 * h) * damping_.D.cwiseProduct(z_.head(r));
  if (free_ != nullptr) {
    residual_.segment<3>(r) = own_spin_residual_ - h * (motion_.turn.transpose() * contact_torque_);
    residual_.tail<3>() = own_centre_residual_ - contact_force_;
  }
  return size_of_residual();
}

// The Jacobian of the residual that evaluate() left, without the gyroscopic terms of a turning
// frame, which are of a higher order in h.
void ContactStep::make_jacobian(double heavier) {
  const double h = options_.step;
  const Index r = model_->modes();
  const VectorXd& n = damping_.n;
  model_->potential().averaged_jacobian(q0_, q1_, workspace_, K_);
  jacobian_.setZero();
  jacobian_.topLeftCorner(r, r) = (0.5 * h * h + h * strain_.beta()) * K_;
  if (strain_.present())
    jacobian_.topLeftCorner(r, r).diagonal() -= (0.5 * h * strain_.beta()) * model_->lambda();
  jacobian_.topLeftCorner(r, r).diagonal() +=
      ((0.5 + 0.5 * heavier) * n.array().square() * S_.array() + 0.5 * h * damping_.D.array())
          .matrix();
  if (free_ != nullptr) {
    const Eigen::Matrix3Xd& C1 = free_->end_coupling();
    for (Index j = 0; j < r; ++j) {
      jacobian_.block<1, 3>(j, r) = (0.25 * h * n[j] * S_[j]) * C1.col(j).transpose();
      jacobian_.block<3, 1>(r, j) = (S_[j] * n[j] / h) * C1.col(j);
    }
    jacobian_.block<3, 3>(r, r) = (1.0 + heavier) * spin_jacobian_;
    jacobian_.bottomRightCorner<3, 3>().diagonal().setConstant((1.0 + heavier) * 2.0 * mass_ /
                                                               (h * h));
  }
  for (const Candidate& candidate : touching()) {
    if (!candidate.now.acts) continue;
    lever_.make(motion_, candidate.touch, point_rows(candidate.point));
    const PlacedCollider& collider = colliders_[candidate.collider];
    lever_.add_tangent(contact_stiffness(candidate.law, collider, candidate.start,
                                         candidate.touch.x1, h, candidate.held),
                       jacobian_);
    add_geometry_at_point(candidate.now.force, candidate.touch, candidate.point);
  }
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const double stiffness = 0.5 * grips_[i].stiffness + grips_[i].damping / h;
    const PlaceRows rows = place_rows(grips_[i].place);
    lever_.make(motion_, held_[i], rows);
    lever_.add_tangent(stiffness * Matrix3d::Identity(), jacobian_);
    if (free_ == nullptr) continue;
    lever_.make_swing(motion_, held_[i], rows);
    add_geometry(grips_[i].force, grips_[i].force, held_[i], rows);
  }
}

double renewal(int iteration, double size) {
  if (iteration >= kRenewals || size < kHeldBelow) return 0.0;
  return iteration < kFullRenewals ? 1.0 : 0.5;
}

// heavier: of the first moves.
bool ContactStep::solve(double heavier, StepReport& report) {
  const double h = options_.step;
  const Index n = unknowns();
  evaluate(0.0);
  double size = close(), enough = this->enough();
  for (int i = 0; i < kNewtonIterations; ++i) {
    if (const double renew = renewal(i, size / enough); renew > 0.0) {
      evaluate(renew);
      size = close();
    }
    report.residual = 0.5 * h * size;
    enough = this->enough();
    if (size <= enough) return true;
    if (!std::isfinite(size)) return false;
    z_before_ = z_;
    const auto go = [&](double length) {
      z_.head(n) = z_before_.head(n) - length * move_.head(n);
      evaluate(0.0);
      const double next = close();
      return LineTrial{next, -work_along(move_.head(n))};
    };
    const auto find_move = [&](double added) {
      make_jacobian(added);
      factor_.compute(jacobian_.topLeftCorner(n, n));
      move_.head(n) = factor_.solve(residual_.head(n));
      return -work_along(move_.head(n));
    };
    LineTrial reached;
    const bool small = size <= 1e3 * enough;
    if (!newton_move(find_move, go, size, small, heavier, reached)) return small;
    // A move that rounding of the points' places swallows.
    if (way_of_move() <= kRoundedWay * points_->extent) return true;
    ++report.iterations;
    // At rounding no move helps.
    if (!(reached.size < 0.9 * size) && small) {
      if (reached.size > size) go(0.0);
      return true;
    }
    size = reached.size;
  }
  return false;
}

StepReport ContactStep::step(State& state, const StepLoad& load, FreeFrame* free) {
  StepReport report;
  // From the beginning once more with short moves, where long ones led astray.
  for (const double heavier : {0.0, 10.0, 1000.0}) {
    begin(state, load, free);
    in_island_ = false;
    report.converged = solve(heavier, report) && z_.allFinite();
    if (report.converged) break;
  }
  if (report.converged) finish(state, report);
  return report;
}

// The state at the end, with the forces of contact as they were found: omega1 last and to rounding.
void ContactStep::finish(State& state, StepReport& report) {
  const double h = options_.step;
  const VectorXd& n = damping_.n;
  VectorXd& d = middle_;
  d = z_.head(model_->modes());
  settle_account();
  if (free_ != nullptr) {
    free_->set_contact(contact_force_, contact_torque_);
    dp_ = S_.cwiseProduct(n.cwiseProduct(d) / h - v0_);
    force_ = G_ - load_->average;
    if (strain_.present()) force_ += rest_ / h;
    free_->evaluate(d, S_, dp_, force_);
    force_ -= contact_push_;
  }
  const double defect =
      (2.0 / (h * h)) * d.dot((0.5 * h) * n.cwiseProduct(dp_) + (0.5 * h * h) * force_ +
                              (0.5 * h) * damping_.D.cwiseProduct(d));
  report.dissipated = damping_.D.dot(d.cwiseAbs2()) / h +
                      h * damping_.theta.cwiseProduct(damping_.D).dot(dp_.cwiseAbs2()) + rest_work_;
  state.q = q1_;
  if (load_->coupling == nullptr || !load_->coupling->finish(d, defect, state.p)) {
    state.p += dp_;
    give_back(defect, 0.5 * state.p.squaredNorm(), state.p);
  }
}

void ContactStep::carry(StateStream& stream) {
  stream(account_, poses_.start, poses_.end, ball_.centre, ball_.radius, ball_.deformed);
  stream(ball_.travel, q0_, u0_);
  stream.sized(impulses_);
}

}  // namespace tremolo
