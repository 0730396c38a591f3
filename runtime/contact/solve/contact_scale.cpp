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

// Converts all rows to momenta, kg^1/2 m/s.
double ContactStep::size_of_residual() const {
  const Index n = unknowns();
  return row_scale_.head(n).cwiseProduct(residual_.head(n)).norm();
}

double ContactStep::work_along(const Eigen::Ref<const VectorXd>& move) const {
  const double h = options_.step;
  const Index r = model_->modes();
  double work = 2.0 / (h * h) * residual_.head(r).dot(move.head(r));
  if (free_ != nullptr) {
    work += 0.5 * residual_.segment<3>(r).dot(move.segment<3>(r));
    work += residual_.segment<3>(r + 3).dot(move.segment<3>(r + 3));
  }
  return work;
}

// Unit of size_of_residual(): momenta, and forces times h. The first residual of a step is that of
// all forces on a body that continues its motion.
double ContactStep::size_of_motion() const {
  const double h = options_.step;
  double size =
      first_size_ + v0_.norm() + h * (G_.norm() + load_->average.norm() + contact_push_.norm());
  if (free_ == nullptr) return size;
  const RigidState& rigid = free_->rigid();
  const double root = std::sqrt(mass_);
  size += root * (rigid.velocity.norm() + points_->radius * rigid.spin.norm());
  size += h / root * (contact_force_.norm() + contact_torque_.norm() / points_->radius);
  return size;
}

// Rounding error of the momenta from a position at the distance `far` from the world's origin.
double ContactStep::held_rounding(const VertexRows& place, double stiffness, double far) const {
  const double lightness = place.rows.norm() + (free_ != nullptr ? 1.0 / std::sqrt(mass_) : 0.0);
  return 4.0 * std::numeric_limits<double>::epsilon() * options_.step * stiffness * lightness *
         (far + points_->extent);
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
  joints_rounding_ += held_rounding(place, 0.5 * stiffness, 2.0 * motion_.c0.norm());
}

// Largest displacement of any point by move_, m.
double ContactStep::way_of_move() const {
  const Index r = model_->modes();
  const double way = move_.head(r).cwiseAbs().dot(points_->reach);
  if (free_ == nullptr) return way;
  const double turned = options_.step * points_->radius * move_.segment<3>(r).norm();
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
    const Vector3d mean_force = 0.5 * (motion_.R0 + motion_.R1).transpose() * grip.force;
    grip.work = free_ != nullptr ? grip.force.dot(touch.x1 - touch.x0)
                                 : (grip.place.rows * z_.head(model_->modes())).dot(mean_force);
    account_.hand_work += grip.work;
    account_.hand_damped += grip.damped;
  }
}

// The law of a point, scaled by its area. The friction spring is as stiff as the contact at half
// the margin, or where it is linear.
ContactLaw ContactStep::law_of(std::size_t point, double friction, double restitution) const {
  ContactLaw law = law_;
  law.friction = friction;
  law.restitution = restitution;
  law.stiffness *= points_->areas[point];
  law.shear = law.stiffness * std::min(law.margin, 2.0 * law.linear_from);
  law.shear_damping = dampers_[point] * std::sqrt(law.shear);
  return law;
}

// Two bodies are two springs in series. Their stiffnesses are the slopes of the pressure at the
// depth at which both count as linear, otherwise their kappa. If each body has points on the
// other's shape, all of them act. Friction and restitution are geometric means; the rebound is
// whole from the lower speed on.
ContactLaw ContactStep::law_of(std::size_t point, const ContactStep& other) const {
  const ContactLaw& theirs = other.law_;
  ContactLaw law = law_of(point, std::sqrt(law_.friction * theirs.friction),
                          std::sqrt(law_.restitution * theirs.restitution));
  const double both = std::min(law_.linear_from, theirs.linear_from);
  const auto slope = [both](const ContactLaw& one) {
    return std::isfinite(both) ? one.stiffness * std::min(one.margin, one.linear_from) / both
                               : one.stiffness;
  };
  law.rebound_speed = std::min(law_.rebound_speed, theirs.rebound_speed);
  const double own = slope(law_), other_slope = slope(theirs);
  const double before = law.shear;
  law.linear_from = both;
  law.stiffness = points_->areas[point] * own * other_slope / (own + other_slope);
  law.shear = law.stiffness * std::min(law.margin, 2.0 * law.linear_from);
  if (before > 0.0) law.shear_damping *= std::sqrt(law.shear / before);
  return law;
}

// About half of critical damping for the effective mass of a point: c = (k m)^1/2.
void ContactStep::find_dampers() {
  const Index r = model_->modes();
  const Eigen::ArrayXd give =
      1.0 / (1.0 + (0.25 * kContactTime * kContactTime) * model_->lambda().array());
  for (std::size_t i = 0; i < points_->size(); ++i) {
    const auto rows = points_->rows.middleCols<3>(static_cast<Index>(3 * i));
    double lightness = can_move_ ? 1.0 / mass_ : 0.0;
    for (Index k = 0; k < r; ++k) lightness += rows.row(k).squaredNorm() * give[k] / 3.0;
    dampers_.push_back(lightness > 0.0 ? std::sqrt(1.0 / lightness) : 0.0);
  }
}

void ContactStep::settle_account() {
  const double before = account_.energy;
  account_ = {};
  impulses_.assign(impulses_.size(), 0.0);
  collider_impulses_.assign(collider_impulses_.size(), Vector3d::Zero());
  contacted_.clear();
  account_ = pairs_;
  double start = pairs_start_;
  for (const Candidate& candidate : touching()) {
    const ContactForce& now = candidate.now;
    start +=
        candidate.start.energy + 0.5 * candidate.law.shear * candidate.memory.slip.squaredNorm();
    account_.energy += now.energy;
    account_.lost += now.lost;
    account_.rubbed += now.rubbed;
    account_.work += now.force.dot(candidate.touch.x1 - candidate.touch.x0);
    account_.penetration = std::max(account_.penetration, -now.distance);
    bool through = false;
    const double way =
        contact_passage(colliders_[candidate.collider], candidate.start, candidate.end, through);
    account_.way = std::max(account_.way, way);
    account_.passed += through ? 1 : 0;
    if (now.pressure == 0.0) continue;
    const double impulse = options_.step * now.force.norm();
    impulses_[candidate.collider] += impulse;
    collider_impulses_[candidate.collider] -= options_.step * now.force;
    const Pose& frame = colliders_[candidate.collider].end;
    contacted_.push_back({.vertex = points_->ids[candidate.point],
                          .obstacle = candidate.collider,
                          .position = candidate.touch.x1,
                          .normal = frame.rotation * candidate.held.normal.normalized(),
                          .impulse = options_.step * now.force});
    account_.impulse += impulse;
    account_.impulse_vector += options_.step * now.force;
    ++account_.active;
  }
  settle_grips();
  if (free_ == nullptr)
    account_.work =
        contact_push_.dot(z_.head(model_->modes())) - account_.hand_work - account_.joint_work;
  account_.surplus = start - before;
  account_.given = account_.work + account_.energy - start + account_.lost + account_.rubbed;
}

void ContactStep::keep_part() {
  ContactAccount& sum = parts_.account;
  const ContactAccount before = sum;
  sum = account_;
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
  parts_.impulses.resize(impulses_.size(), 0.0);
  parts_.collider_impulses.resize(impulses_.size(), Vector3d::Zero());
  for (std::size_t c = 0; c < impulses_.size(); ++c) {
    parts_.impulses[c] += impulses_[c];
    parts_.collider_impulses[c] += collider_impulses_[c];
  }
  for (const ContactedPoint& point : contacted_) {
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
  account_ = parts_.account;
  impulses_.assign(parts_.impulses.begin(), parts_.impulses.end());
  collider_impulses_.assign(parts_.collider_impulses.begin(), parts_.collider_impulses.end());
  contacted_.assign(parts_.contacted.begin(), parts_.contacted.end());
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
  row_scale_.setConstant(r + 6, 2.0 / options_.step);
  row_scale_.segment<3>(r).setConstant(1.0 / (std::sqrt(mass_) * points_->radius));
  row_scale_.tail<3>().setConstant(options_.step / std::sqrt(mass_));
}

void ContactStep::set_step(double step) {
  options_.step = motion_.h = step;
  damping_ = make_inertia_damping(*model_, options_, cotangent_weight);
  S_ = (0.5 + step * damping_.theta.array() * damping_.D.array()).inverse();
  scale_rows();
}

}  // namespace tremolo
