// ContactStep: measures of a residual, and the energy balance of a step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kMomentaTolerance = 1e-10;  // of the momenta in a step

}  // namespace

// Unit of size_of_residual(): momenta, and forces times h. The first residual of a step is that of
// all forces on a body that continues its motion.
double ContactStep::size_of_motion() const {
  const double h = options_.step;
  double size =
      first_size_ + v0_.norm() + h * (G_.norm() + load_->average.norm() + eq_.pushed.norm());
  if (free_ == nullptr) return size;
  const RigidState& rigid = free_->rigid();
  const double root = std::sqrt(mass_);
  size += root * (rigid.velocity.norm() + eq_.points->radius * rigid.spin.norm());
  size += h / root * (eq_.force.norm() + eq_.torque.norm() / eq_.points->radius);
  return size;
}

// Rounding error of the momenta from a position at the distance `far` from the world's origin.
double ContactStep::held_rounding(const VertexRows& place, double stiffness, double far) const {
  const double lightness = place.rows.norm() + (free_ != nullptr ? 1.0 / std::sqrt(mass_) : 0.0);
  return 4.0 * std::numeric_limits<double>::epsilon() * options_.step * stiffness * lightness *
         (far + eq_.points->extent);
}

double ContactStep::grips_rounding() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const Grip& grip = grips_[i];
    const double stiffness = 0.5 * grip.stiffness + grip.damping / options_.step;
    sum += held_rounding(grip.place, stiffness, held_[i].x1.norm() + grip.end.norm());
  }
  return sum;
}

void ContactStep::hold_at(const VertexRows& place, double stiffness) {
  joints_rounding_ += held_rounding(place, 0.5 * stiffness, 2.0 * eq_.motion.c0.norm());
}

// Largest displacement of any point by move_, m.
double ContactStep::way_of_move() const {
  const Index r = model_->modes();
  const double way = move_.head(r).cwiseAbs().dot(eq_.points->reach);
  if (free_ == nullptr) return way;
  const double turned = options_.step * eq_.points->radius * move_.segment<3>(r).norm();
  return way + turned + move_.segment<3>(r + 3).norm();
}

double ContactStep::enough() const {
  return std::max({kMomentaTolerance * size_of_motion(), grips_rounding() + joints_rounding_,
                   std::numeric_limits<double>::min()});
}

// A grab's work; for a driven body the work on the motion relative to the frame.
void ContactStep::settle_grips() {
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    Grip& grip = grips_[i];
    const ContactTouch& touch = held_[i];
    const Vector3d way = touch.x1 - touch.x0 - (grip.end - grip.start);
    grip.damped = grip.damping / options_.step * way.squaredNorm();
    const Vector3d mean_force = 0.5 * (eq_.motion.R0 + eq_.motion.R1).transpose() * grip.force;
    grip.work = free_ != nullptr ? grip.force.dot(touch.x1 - touch.x0)
                                 : (grip.place.rows * eq_.z.head(model_->modes())).dot(mean_force);
    record_.account.hand_work += grip.work;
    record_.account.hand_damped += grip.damped;
  }
}

// Bound of the rounding error of a distance, and of its change, near the body, m.
double ContactStep::distance_rounding() const {
  constexpr double kRoundings = 32.0;
  return kRoundings * std::numeric_limits<double>::epsilon() *
         (eq_.points->extent + ball_.centre.norm());
}

// The law of a point, scaled by its area. The friction spring is as stiff as the contact at half
// the margin, or where it is linear.
ContactLaw ContactStep::law_of(std::size_t point, double friction, double restitution) const {
  ContactLaw law = law_;
  law.friction = friction;
  law.restitution = restitution;
  law.stiffness *= eq_.points->areas[point];
  law.shear = law.stiffness * std::min(law.margin, 2.0 * law.linear_from);
  law.shear_damping = dampers_[point] * std::sqrt(law.shear);
  law.radius = eq_.points->radius_of(point);
  if (eq_.points->rigid()) law.rounding = distance_rounding();
  return law;
}

// Friction and restitution of two bodies are geometric means.
ContactLaw ContactStep::law_of(std::size_t point, const ContactStep& other) const {
  const ContactLaw& theirs = other.law_;
  ContactLaw law = law_in_series(law_of(point, std::sqrt(law_.friction * theirs.friction),
                                        std::sqrt(law_.restitution * theirs.restitution)),
                                 law_, theirs, eq_.points->areas[point]);
  if (eq_.points->rigid() || other.points().rigid())
    law.rounding = distance_rounding() + other.distance_rounding();
  return law;
}

// About half of critical damping for the effective mass of a point: c = (k m)^1/2.
void ContactStep::find_dampers() {
  const Index r = model_->modes();
  const Eigen::ArrayXd give =
      1.0 / (1.0 + (0.25 * kContactTime * kContactTime) * model_->lambda().array());
  for (std::size_t i = 0; i < eq_.points->size(); ++i) {
    const auto rows = eq_.points->rows.middleCols<3>(static_cast<Index>(3 * i));
    double lightness = can_move_ ? 1.0 / mass_ : 0.0;
    for (Index k = 0; k < r; ++k) lightness += rows.row(k).squaredNorm() * give[k] / 3.0;
    dampers_.push_back(lightness > 0.0 ? std::sqrt(1.0 / lightness) : 0.0);
  }
}

void ContactStep::settle_account() {
  const double before = record_.account.energy;
  record_.account = {};
  record_.impulses.assign(record_.impulses.size(), 0.0);
  record_.collider_impulses.assign(record_.collider_impulses.size(), Vector3d::Zero());
  record_.contacted.clear();
  record_.account = pairs_;
  double start = pairs_start_;
  for (const Candidate& candidate : touching()) {
    const ContactForce& now = candidate.now;
    start +=
        candidate.start.energy + 0.5 * candidate.law.shear * candidate.memory.slip.squaredNorm();
    record_.account.energy += now.energy;
    record_.account.lost += now.lost;
    record_.account.rubbed += now.rubbed;
    record_.account.work += now.force.dot(candidate.touch.x1 - candidate.touch.x0);
    const bool round = candidate.law.radius > 0.0;
    if (round)
      record_.account.work += now.rub.dot(eq_.motion.turn_in_step().cross(surface_of(candidate)));
    record_.account.penetration = std::max(record_.account.penetration, -now.distance);
    bool through = false;
    const double way =
        contact_passage(colliders_[candidate.collider], candidate.start, candidate.end, through);
    record_.account.way = std::max(record_.account.way, way);
    record_.account.passed += through ? 1 : 0;
    if (now.pressure == 0.0) continue;
    const double impulse = options_.step * now.force.norm();
    record_.impulses[candidate.collider] += impulse;
    record_.collider_impulses[candidate.collider] -= options_.step * now.force;
    const Pose& frame = colliders_[candidate.collider].end;
    record_.contacted.push_back(
        {.vertex = eq_.points->ids[candidate.point],
         .obstacle = candidate.collider,
         .position =
             round ? Vector3d(candidate.touch.x1 + surface_of(candidate)) : candidate.touch.x1,
         .normal = frame.rotation * candidate.held.normal.normalized(),
         .impulse = options_.step * now.force});
    record_.account.impulse += impulse;
    record_.account.impulse_vector += options_.step * now.force;
    ++record_.account.active;
  }
  settle_grips();
  if (free_ == nullptr)
    record_.account.work = eq_.pushed.dot(eq_.z.head(model_->modes())) - record_.account.hand_work -
                           record_.account.joint_work;
  record_.account.surplus = start - before;
  record_.account.given = record_.account.work + record_.account.energy - start +
                          record_.account.lost + record_.account.rubbed;
}

void ContactStep::keep_part() {
  ContactAccount& sum = parts_.account;
  const ContactAccount before = sum;
  sum = record_.account;
  for (double ContactAccount::*each :
       {&ContactAccount::work, &ContactAccount::lost, &ContactAccount::rubbed,
        &ContactAccount::given, &ContactAccount::surplus, &ContactAccount::hand_work,
        &ContactAccount::hand_damped, &ContactAccount::joint_work, &ContactAccount::impulse})
    sum.*each += before.*each;
  sum.penetration = std::max(sum.penetration, before.penetration);
  sum.way += before.way;
  sum.active = std::max(sum.active, before.active);
  sum.passed += before.passed;
  sum.impulse_vector += before.impulse_vector;
  parts_.impulses.resize(record_.impulses.size(), 0.0);
  parts_.collider_impulses.resize(record_.impulses.size(), Vector3d::Zero());
  for (std::size_t c = 0; c < record_.impulses.size(); ++c) {
    parts_.impulses[c] += record_.impulses[c];
    parts_.collider_impulses[c] += record_.collider_impulses[c];
  }
  for (const ContactedPoint& point : record_.contacted) {
    const auto same = [&point](const ContactedPoint& other) {
      return other.vertex == point.vertex && other.on_body == point.on_body &&
             other.obstacle == point.obstacle;
    };
    const auto found = std::find_if(parts_.contacted.begin(), parts_.contacted.end(), same);
    if (found == parts_.contacted.end()) {
      parts_.contacted.push_back(point);
      continue;
    }
    const Vector3d before_it = found->impulse;
    *found = point;
    found->impulse += before_it;
  }
}

void ContactStep::end_parts(bool made) {
  colliders_ = {};
  if (!made) return;
  record_.account = parts_.account;
  record_.impulses.assign(parts_.impulses.begin(), parts_.impulses.end());
  record_.collider_impulses.assign(parts_.collider_impulses.begin(),
                                   parts_.collider_impulses.end());
  record_.contacted.assign(parts_.contacted.begin(), parts_.contacted.end());
}

void ContactStep::set_damping(double alpha, double beta) {
  options_.alpha = alpha;
  options_.beta = beta;
  damping_ = make_inertia_damping(*model_, options_, cotangent_weight);
  strain_ = StrainDamping(*model_, options_.beta);
  S_ = (0.5 + options_.step * damping_.theta.array() * damping_.D.array()).inverse();
}

void ContactStep::scale_rows() {
  const Index r = model_->modes();
  eq_.row_scale.setConstant(r + 6, 2.0 / options_.step);
  eq_.row_scale.segment<3>(r).setConstant(1.0 / (std::sqrt(mass_) * eq_.points->radius));
  eq_.row_scale.tail<3>().setConstant(options_.step / std::sqrt(mass_));
}

void ContactStep::set_step(double step) {
  options_.step = eq_.motion.h = step;
  damping_ = make_inertia_damping(*model_, options_, cotangent_weight);
  S_ = (0.5 + step * damping_.theta.array() * damping_.D.array()).inverse();
  scale_rows();
}

}  // namespace tremolo
