#include "runtime/mixed/collider_contact.h"

#include <algorithm>

#include "runtime/contact/contact_memories.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

double distance_at(const Collider& shape, const Pose& pose, const Vector3d& x) {
  return signed_distance(shape, pose.rotation.conjugate() * (x - pose.position)).distance;
}

// Bound of the displacement of the collider near a ball of that radius about x, m.
double travel_of(const PlacedCollider& collider, const Vector3d& x, double radius) {
  const Vector3d local = collider.start.rotation.conjugate() * (x - collider.start.position);
  const double angle = turn_of(collider.start.rotation.conjugate() * collider.end.rotation).norm();
  return (collider.end * local - x).norm() + angle * radius;
}

}  // namespace

void ColliderContact::add(std::size_t point) {
  Touch& touch = touches_.emplace_back();
  touch.point = point;
  touch.law = points_->law_of(point, collider_->friction, collider_->restitution);
  const ContactMemory* memory = points_->memory(obstacle_, point);
  const Vector3d x = points_->start_of(point);
  touch.start = contact_start(touch.law, *collider_, x, x, memory);
  if (memory != nullptr)
    touch.memory = *memory;
  else
    touch.memory.begins = kNoLevel;
}

// Sets B and the energies of the points from number `from` on.
void ColliderContact::set_levels(std::size_t from) {
  ContactLevel level;
  for (const Touch& touch : touches_)
    level.add(touch.memory.begins, touch.start.distance, touch.law.margin);
  for (std::size_t k = from; k < touches_.size(); ++k) {
    Touch& touch = touches_[k];
    touch.memory.begins = level.of(touch.memory.begins, touch.start.distance, touch.law.margin);
    touch.law.begins = touch.memory.begins;
    touch.start.energy = touch.law.energy(touch.start.distance);
  }
}

bool ColliderContact::gather(StepBody& points, const PlacedCollider& collider, std::size_t obstacle,
                             double h) {
  points_ = &points;
  collider_ = &collider;
  obstacle_ = obstacle;
  h_ = h;
  turns_ = turns_of(collider);
  touches_.clear();
  const StepBall ball = points.ball();
  const double reach = points.area_law().margin +
                       2.0 * (ball.travel + travel_of(collider, ball.centre, ball.radius)) +
                       points.reach_of_sides(obstacle);
  if (distance_at(collider.shape, collider.start, ball.centre) > ball.radius + reach) return false;
  for (std::size_t i = 0; i < points.points(); ++i)
    if (distance_at(collider.shape, collider.start, points.start_of(i)) <= reach) add(i);
  set_levels(0);
  return !touches_.empty();
}

void ColliderContact::begin(Touch& touch) const {
  touch.now = {};
  touch.held = {};
  hold_normal(touch.start.normal, touch.memory, touch.held);
  touch.held.limit = touch.memory.limit;
}

void ColliderContact::begin() {
  for (Touch& touch : touches_) begin(touch);
}

void ColliderContact::approach(const ContactRenewal& renewal) {
  (void)renewal;
  for (Touch& touch : touches_) {
    touch.motion = points_->motion(touch.point);
    touch.end = contact_end(touch.law, *collider_, turns_, touch.start, touch.motion.end);
    shared->rate.add(touch.end.gap.pressure, touch.end.gap.d1 - touch.end.gap.d0);
  }
}

void ColliderContact::press(const ContactRenewal& renewal) {
  for (Touch& touch : touches_) {
    touch.now = contact_force(touch.law, *collider_, turns_, touch.start, touch.memory, touch.end,
                              time(), renewal, touch.held);
    if (touch.now.acts) points_->add_force(touch.point, touch.now.force);
  }
}

void ColliderContact::make_slopes(bool follows) {
  for (Touch& touch : touches_) {
    if (!touch.now.acts) continue;
    touch.slope =
        contact_slope(touch.law, turns_, touch.start, touch.end, time(), touch.held, follows);
    points_->add_slope(touch.point, touch.slope.by_end, touch.now.force);
  }
}

void ColliderContact::add_growth(StepBody::In first_x, StepBody::In second_x) {
  (void)second_x;
  if (!(shared->rate.force > 0.0)) return;
  for (const Touch& touch : touches_)
    if (touch.now.acts)
      shared->growth += touch.slope.taken.dot(points_->change_at(touch.point, first_x));
}

void ColliderContact::multiply(StepBody::In first_x, StepBody::In second_x,
                               StepBody::Out first_rows, StepBody::Out second_rows) const {
  (void)first_x;
  (void)second_x;
  (void)second_rows;
  if (shared->growth == 0.0) return;
  for (const Touch& touch : touches_)
    if (touch.now.acts)
      points_->add_image(touch.point, shared->growth * touch.slope.by_taken, first_rows);
}

bool ColliderContact::add_missed() {
  listed_.assign(points_->points(), 0);
  for (const Touch& touch : touches_) listed_[touch.point] = 1;
  const std::size_t known = touches_.size();
  const double margin = points_->area_law().margin;
  for (std::size_t i = 0; i < points_->points(); ++i) {
    if (listed_[i] != 0) continue;
    const Vector3d end = points_->motion(i).end;
    if (!(distance_at(collider_->shape, collider_->end, end) < margin)) continue;
    add(i);
  }
  set_levels(known);
  for (std::size_t k = known; k < touches_.size(); ++k) begin(touches_[k]);
  return touches_.size() != known;
}

void ColliderContact::settle(ContactAccount& first_account, ContactAccount& second_account,
                             double& first_start, double& second_start) const {
  (void)second_account;
  (void)second_start;
  ContactAccount& sum = first_account;
  for (const Touch& touch : touches_) {
    const ContactForce& now = touch.now;
    first_start += touch.start.energy + 0.5 * touch.law.shear * touch.memory.slip.squaredNorm();
    sum.energy += now.energy;
    sum.lost += now.lost;
    sum.friction_loss += now.friction_loss;
    sum.work += now.force.dot(touch.motion.end - touch.motion.start);
    sum.penetration = std::max(sum.penetration, -now.distance);
    sum.slip = std::max(sum.slip, held_slip(touch.law, now));
    bool through = false;
    sum.way = std::max(sum.way, contact_passage(*collider_, touch.start, touch.end, through));
    sum.passed += through ? 1 : 0;
    if (now.pressure == 0.0) continue;
    sum.impulse += h_ * now.force.norm();
    sum.impulse_vector += h_ * now.force;
    ++sum.active;
  }
}

void ColliderContact::remember() {
  for (const Touch& touch : touches_) {
    if (touch.now.pressure != 0.0)
      points_->note({.vertex = points_->number_of(touch.point),
                     .obstacle = obstacle_,
                     .position = touch.motion.end,
                     .normal = collider_->end.rotation * touch.held.normal.normalized(),
                     .impulse = h_ * touch.now.force});
    if (!(touch.now.distance < touch.law.margin) || touch.now.released) continue;
    const double length = touch.held.normal.norm();
    points_->remember({.obstacle = obstacle_,
                       .point = touch.point,
                       .begins = touch.law.begins,
                       .limit = touch.now.limit,
                       .slip = touch.now.slip,
                       .normal = length > 0.0 ? Vector3d(touch.held.normal / length)
                                              : Vector3d(Vector3d::UnitZ()),
                       .side = touch.end.side,
                       .depth = touch.end.side.counts() ? touch.now.distance : 0.0});
  }
}

std::size_t ColliderContact::acting() const {
  return static_cast<std::size_t>(std::count_if(touches_.begin(), touches_.end(),
                                                [](const Touch& touch) { return touch.now.acts; }));
}

}  // namespace tremolo
