#include "runtime/mixed/hull_contact.h"

#include <algorithm>
#include <cmath>

#include "runtime/bodies/tets/elements/element_turn.h"

namespace tremolo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// delta as a fraction of the margin. The stiffness of the correction grows as its inverse: below
// this it exceeds that of friction, and points that stick keep moves short.
constexpr double kCreased = 0.1;

bool HullContact::gather(StepBody& points, TetStep& shape, std::size_t obstacle, double h) {
  points_ = &points;
  shape_ = &shape;
  obstacle_ = obstacle;
  h_ = h;
  touches_.clear();
  if (!shape.has_hull()) return false;
  const StepBall mine = points.ball(), other = shape.ball();
  const double reach = 2.0 * (mine.travel + other.travel);
  if ((mine.centre - other.centre).norm() > mine.radius + other.radius + reach) return false;
  TetTree::Box box = shape.box_at_start();
  box.min().array() -= reach;
  box.max().array() += reach;
  const ContactLaw theirs = shape.area_law(), own = points.area_law_with(theirs);
  for (std::size_t i = 0; i < points.points(); ++i) {
    const Vector3d x = points.start_of(i);
    if (!points.feels(i) || !box.contains(x)) continue;
    Touch& touch = touches_.emplace_back();
    touch.point = i;
    touch.law = law_in_series(points.law_of(i, std::sqrt(own.friction * theirs.friction),
                                            std::sqrt(own.restitution * theirs.restitution)),
                              own, theirs, points.area_of(i));
    touch.law.rounding += shape.rounding();
    const ContactMemory* memory = points.memory(obstacle, i);
    const std::optional<TetDepth> depth =
        shape.depth_at_start(x, memory != nullptr ? std::optional(memory->element) : std::nullopt);
    touch.inside = depth && depth->distance < 0.0;
    touch.memory = memory != nullptr ? *memory : ContactMemory{};
    if (memory == nullptr) touch.memory.begins = touch.inside ? depth->distance : 0.0;
    touch.law.begins = touch.memory.begins;
    touch.element = touch.inside ? depth->element : 0;
    touch.distance = touch.inside ? depth->distance : 0.0;
    touch.gradient = touch.inside ? depth->gradient : Vector3d(Vector3d::Zero());
    touch.normal = touch.inside ? depth->normal : Vector3d(Vector3d::Zero());
    touch.energy = touch.inside ? touch.law.energy(touch.distance) : 0.0;
  }
  if (!touches_.empty()) shape.follow_hull();
  return !touches_.empty();
}

void HullContact::begin() {
  for (Touch& touch : touches_) {
    touch.now = {};
    touch.held = {};
    touch.kept_element.reset();
    touch.held.limit = touch.memory.limit;
    touch.held.normal.setZero();
  }
}

// Finds the point at the end of the step, and the path along the body. Distances by different
// elements differ outside of them: like the normal the element is kept along a move.
void HullContact::find_end(Touch& touch, bool renews) {
  if (renews) touch.kept_element.reset();
  const std::optional<std::uint32_t> start =
      touch.inside ? std::optional(touch.element) : std::nullopt;
  const std::optional<TetDepth> depth =
      shape_->depth_at_end(touch.motion.end, touch.kept_element ? touch.kept_element : start,
                           touch.kept_element.has_value());
  const bool inside = depth && depth->distance < 0.0;
  if (inside) touch.kept_element = depth->element;
  touch.near =
      (inside || touch.inside) &&
      shape_->find_site(touch.motion.middle, inside ? depth->element : touch.element, touch.site);
  if (!touch.near) return;
  touch.end_site = touch.site;
  if (inside) {
    touch.end_site.element = depth->element;
    touch.end_site.values = depth->values;
  }
  touch.axes = nearest_rotation(touch.site.gradient);
  touch.way.path = touch.motion.end - touch.motion.start - shape_->way_of(touch.site);
  touch.end_gradient = inside ? depth->gradient : touch.normal;
  touch.end_element = inside ? depth->element : touch.element;
  touch.end_normal = inside ? depth->normal : touch.normal;
  double d0 = touch.distance, d1 = inside ? depth->distance : 0.0;
  if (!touch.inside) d0 = std::max(0.0, d1 - touch.end_normal.dot(touch.way.path));
  if (!inside) d1 = std::max(0.0, d0 + touch.normal.dot(touch.way.path));
  if (renews || touch.held.normal.isZero(0.0)) hold_normal_of(touch);
  find_gap(touch, d0, d1);
}

void HullContact::hold_normal_of(Touch& touch) {
  ContactMemory memory = touch.memory;
  memory.slip = touch.axes * memory.slip;
  memory.normal = touch.axes * memory.normal;
  const Vector3d start = touch.inside ? touch.normal : touch.end_normal;
  // Past the middle the normals of both ends may be opposite.
  const bool turned = start.dot(touch.end_normal) < 0.0;
  hold_normal(turned ? start : Vector3d(0.5 * (start + touch.end_normal)), memory, touch.held);
}

// The law's distance at the end, and its slope. A point that begins outside has m = 0 by its d0.
void HullContact::find_gap(Touch& touch, double d0, double d1) {
  const Vector3d& path = touch.way.path;
  touch.end = d1;
  touch.part = 1.0;
  touch.part_slope.setZero();
  double missed = 0.0;
  if (touch.inside) {
    const double delta = kCreased * touch.law.margin, delta2 = delta * delta;
    const double both = path.squaredNorm() + delta2;
    missed = d1 - d0 - touch.held.normal.dot(path);
    touch.part = path.squaredNorm() / both;
    touch.part_slope =
        (1.0 - touch.part) * touch.held.normal + (2.0 * missed * delta2 / (both * both)) * path;
  }
  const double shift = (1.0 - touch.part) * missed;
  touch.begins = std::min(0.0, std::max(touch.law.begins + shift, d1));
  touch.gap = make_gap(touch.law, d0, touch.energy, d1 - shift);
}

void HullContact::approach(const ContactRenewal& renewal) {
  for (Touch& touch : touches_) {
    touch.motion = points_->motion(touch.point);
    find_end(touch, renewal.normals);
    touch.now.clear(touch.near ? touch.end : 0.0,
                    0.5 * touch.law.shear * touch.memory.slip.squaredNorm());
    if (touch.near) shared->rate.add(touch.gap.pressure, touch.gap.d1 - touch.gap.d0);
  }
}

void HullContact::press(const ContactRenewal& renewal) {
  for (Touch& touch : touches_) {
    if (!touch.near) continue;
    touch.now = contact_force(touch.law, touch.gap, touch.way, time(), renewal.limits, touch.held);
    touch.now.distance = touch.end;
    if (!touch.now.acts) continue;
    close_energy(touch);
    points_->add_force(touch.point, touch.now.force);
    shape_->push_site(touch.site, -touch.now.force);
  }
}

// The energy with which the next step does not begin is lost. Outside it has no memory of friction.
void HullContact::close_energy(Touch& touch) {
  ContactForce& now = touch.now;
  const double energy = touch.law.energy(touch.gap.d1);
  // With the B of the next step: psi depends on B - d alone.
  double kept = touch.law.energy(touch.end + touch.law.begins - touch.begins);
  if (!(touch.end < 0.0)) {
    kept = 0.0;
    now.friction_loss += now.energy - energy;
    now.energy = energy;
    now.slip.setZero();
  }
  now.energy -= energy - kept;
  now.lost += energy - kept;
}

void HullContact::make_slopes(bool follows) {
  for (Touch& touch : touches_) {
    if (!touch.near || !touch.now.acts) continue;
    const ContactSlopes slopes =
        contact_slopes(touch.law, touch.gap, touch.way, time(), touch.held, follows);
    const Vector3d& fall = slopes.point.by_distance;
    touch.by_distance = touch.part * fall;
    // At given distances inside.
    Matrix3d by_path = slopes.point.by_path + fall * touch.part_slope.transpose();
    touch.by_way = by_path + touch.by_distance * touch.end_gradient.transpose();
    if (!(touch.end < 0.0)) by_path = touch.by_way;
    // d0 = d1 - n.w.
    if (!touch.inside) {
      touch.by_distance += slopes.by_start;
      touch.by_way += slopes.by_start * (touch.end_gradient - touch.end_normal).transpose();
      by_path -= slopes.by_start * touch.end_normal.transpose();
    }
    shape_->find_slopes(touch.site);
    touch.by_shift = -by_path * shape_->way_slope(touch.site);
    touch.link = slopes.point.by_taken;
    touch.growth = slopes.taken_by_distance * (touch.part * touch.end_gradient + touch.part_slope);
    points_->add_slope(touch.point, touch.by_way, touch.now.force);
    shape_->condense(touch.site);
    shape_->condense(touch.end_site);
    shape_->add_site_slope(touch.site, touch.by_way);
  }
}

double HullContact::change_beyond(const Touch& touch, StepBody::In second_x) const {
  return touch.end_gradient.dot(shape_->change_of(touch.end_site, second_x) -
                                shape_->change_of(touch.site, second_x));
}

void HullContact::add_growth(StepBody::In first_x, StepBody::In second_x) {
  if (!(shared->rate.force > 0.0)) return;
  for (const Touch& touch : touches_)
    if (touch.near && touch.now.acts)
      shared->growth += touch.growth.dot(points_->change_at(touch.point, first_x) -
                                         shape_->change_of(touch.end_site, second_x));
}

void HullContact::multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                           StepBody::Out second_rows) const {
  for (const Touch& touch : touches_) {
    if (!touch.near || !touch.now.acts) continue;
    const Vector3d point = points_->change_at(touch.point, first_x);
    const Vector3d site = shape_->change_of(touch.site, second_x);
    const Vector3d shift = touch.site.inverse * (0.5 * (point - site));
    const Vector3d more = shared->growth * touch.link + touch.by_shift * shift -
                          change_beyond(touch, second_x) * touch.by_distance;
    points_->add_image(touch.point, more - touch.by_way * site, first_rows);
    shape_->add_site_image(touch.site, -more - touch.by_way * point, second_rows);
    shape_->add_shifted_site(touch.site, touch.now.force, shift, second_rows);
  }
}

void HullContact::settle(ContactAccount& first_account, ContactAccount& second_account,
                         double& first_start, double& second_start) const {
  (void)second_start;  // the first body has the memories
  for (const Touch& touch : touches_) {
    const ContactForce& now = touch.now;
    first_start += touch.energy + 0.5 * touch.law.shear * touch.memory.slip.squaredNorm();
    first_account.energy += now.energy;
    first_account.lost += now.lost;
    first_account.friction_loss += now.friction_loss;
    if (!now.acts) continue;
    const Vector3d impulse = h_ * now.force;
    first_account.work += now.force.dot(touch.motion.end - touch.motion.start);
    second_account.work -= now.force.dot(shape_->way_of(touch.site));
    for (ContactAccount* account : {&first_account, &second_account}) {
      account->penetration = std::max(account->penetration, -now.distance);
      account->slip = std::max(account->slip, held_slip(touch.law, now));
      account->impulse += impulse.norm();
      ++account->active;
    }
    first_account.impulse_vector += impulse;
    second_account.impulse_vector -= impulse;
  }
}

void HullContact::remember() {
  for (const Touch& touch : touches_) {
    const double length = touch.held.normal.norm();
    const Vector3d normal =
        length > 0.0 ? Vector3d(touch.held.normal / length) : Vector3d(Vector3d::UnitZ());
    // A point that has left by the end of the step was pushed too.
    if (touch.now.acts && touch.now.pressure != 0.0)
      points_->note({.vertex = points_->number_of(touch.point),
                     .on_body = true,
                     .obstacle = obstacle_,
                     .position = touch.motion.end,
                     .normal = normal,
                     .impulse = h_ * touch.now.force});
    if (!touch.near || !(touch.now.distance < 0.0)) continue;
    const Matrix3d back = touch.axes.transpose();
    points_->remember({.obstacle = obstacle_,
                       .point = touch.point,
                       .begins = touch.begins,
                       .limit = touch.now.limit,
                       .slip = back * touch.now.slip,
                       .normal = back * normal,
                       .element = touch.end_element});
  }
}

std::size_t HullContact::acting() const {
  return static_cast<std::size_t>(std::count_if(touches_.begin(), touches_.end(),
                                                [](const Touch& touch) { return touch.now.acts; }));
}

}  // namespace tremolo
