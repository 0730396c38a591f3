#include "runtime/mixed/bent_contact.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d BentContact::place_at_start(std::size_t point) const {
  return shape_->into_rest_at_start(points_->start_of(point));
}

void BentContact::add(std::size_t point, const Vector3d& y, double distance) {
  if (count_ == pairs_.size()) pairs_.emplace_back();
  PairPoint& pair = pairs_[count_++];
  const ContactLaw& theirs = shape_->surface().law;
  const ContactLaw own = points_->area_law_with(theirs);
  pair.law = law_in_series(points_->law_of(point, std::sqrt(own.friction * theirs.friction),
                                           std::sqrt(own.restitution * theirs.restitution)),
                           own, theirs, points_->area_of(point));
  pair.law.rounding += distance_rounding(shape_->surface(), shape_->gathered().ball);
  place_point(pair, {first, second, obstacle_}, point, points_->memory(obstacle_, point), y,
              distance, Vector3d::Zero(), shape_->equations().shape_at_start());
}

bool BentContact::gather(StepBody& points, ContactStep& shape, std::size_t obstacle) {
  points_ = &points;
  shape_ = &shape;
  obstacle_ = obstacle;
  count_ = 0;
  const Collider* solid = shape.surface().shape_or_null();
  if (solid == nullptr) return false;
  const StepBall mine = points.ball();
  const ContactBall& other = shape.gathered().ball;
  const double bent = other.deformed;
  const double reach = points.area_law().margin + 2.0 * (mine.travel + other.travel) +
                       points.reach_of_sides(obstacle);
  if ((mine.centre - other.centre).norm() > mine.radius + other.radius + bent + reach) return false;
  for (std::size_t i = 0; i < points.points(); ++i) {
    if (shape.on_bones() && !shape.may_reach(points.start_of(i), reach)) continue;
    const Vector3d y = place_at_start(i);
    if (signed_distance(*solid, y).distance > reach + bent) continue;
    const double distance = bent_distance(shape.equations().shape_at_start(), y);
    if (distance <= reach && shape.agrees(points.start_of(i), y)) add(i, y, distance);
  }
  set_levels(used(), 0);
  return count_ != 0;
}

void BentContact::begin() {
  for (PairPoint& pair : used()) begin_pair(pair);
}

void BentContact::approach(const ContactRenewal& renewal) {
  (void)renewal;
  ContactEquations& eq = shape_->equations();
  const double bend = eq.bend_in_step();
  motions_.resize(count_);
  for (std::size_t k = 0; k < count_; ++k) {
    PairPoint& pair = pairs_[k];
    motions_[k] = points_->motion(pair.point);
    pair.touch_a.x0 = motions_[k].start;
    pair.touch_a.x1 = motions_[k].end;
    approach_shape(pair, eq, bend, shared->rate);
  }
}

void BentContact::press(const ContactRenewal& renewal) {
  ContactEquations& eq = shape_->equations();
  for (std::size_t k = 0; k < count_; ++k) {
    PairPoint& pair = pairs_[k];
    press_shape(pair, eq, {motions_[k].end, motions_[k].middle}, time(), renewal, scratch_);
    if (!pair.now.acts) continue;
    points_->add_force(pair.point, pair.now.force);
    push_second(pair, eq);
  }
}

void BentContact::make_slopes(bool follows) {
  ContactEquations& eq = shape_->equations();
  if (slopes_.size() < count_) slopes_.resize(count_);
  link_.setZero(eq.unknowns());
  growth_.setZero(eq.unknowns());
  for (std::size_t k = 0; k < count_; ++k) {
    PairPoint& pair = pairs_[k];
    if (!pair.now.acts) continue;
    SiteSlopes& slopes = slopes_[k];
    add_site_slopes(pair, eq, time(), follows, scratch_, slopes);
    points_->add_slope(pair.point, slopes.by_end, pair.now.force);
    link_ += slopes.shape_link;
    growth_ += slopes.shape_growth;
  }
}

void BentContact::add_growth(StepBody::In first_x, StepBody::In second_x) {
  if (!(shared->rate.force > 0.0)) return;
  for (std::size_t k = 0; k < count_; ++k)
    if (pairs_[k].now.acts)
      shared->growth += slopes_[k].growth.dot(points_->change_at(pairs_[k].point, first_x));
  shared->growth += growth_.dot(second_x);
}

void BentContact::multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                           StepBody::Out second_rows) const {
  const Index n = second_x.size();
  rows_ = shared->growth * link_;
  for (std::size_t k = 0; k < count_; ++k) {
    if (!pairs_[k].now.acts) continue;
    const std::size_t point = pairs_[k].point;
    rows_.noalias() += slopes_[k].shape_by * points_->change_at(point, first_x);
    const Vector3d fall = slopes_[k].by_shape * second_x + shared->growth * slopes_[k].link;
    points_->add_image(point, fall, first_rows);
  }
  second_rows += shape_->equations().row_scale.head(n).cwiseProduct(rows_);
}

bool BentContact::add_missed() {
  const ContactEquations& eq = shape_->equations();
  const Collider& solid = *shape_->surface().shape;
  const double margin = points_->area_law().margin, bent = shape_->gathered().ball.deformed;
  listed_.assign(points_->points(), 0);
  for (const PairPoint& pair : used()) listed_[pair.point] = 1;
  const std::size_t known = count_;
  for (std::size_t i = 0; i < points_->points(); ++i) {
    if (listed_[i] != 0) continue;
    const Vector3d end = eq.into_rest_at_end(points_->motion(i).end);
    if (signed_distance(solid, end).distance > margin + 2.0 * bent) continue;
    if (bent_distance(eq.shape_at_end(), end) >= margin) continue;
    const Vector3d y = place_at_start(i);
    add(i, y, bent_distance(eq.shape_at_start(), y));
  }
  set_levels(used(), known);
  for (PairPoint& pair : used().subspan(known)) begin_pair(pair);
  return count_ != known;
}

void BentContact::settle(ContactAccount& first_account, ContactAccount& second_account,
                         double& first_start, double& second_start) const {
  (void)second_start;  // the first body has the memories
  const ContactEquations& eq = shape_->equations();
  for (const PairPoint& pair : used()) {
    first_start += pair.energy + 0.5 * pair.law.shear * pair.memory.slip.squaredNorm();
    settle_pair(pair, pair.place, eq, eq.motion.h, first_account, second_account);
  }
}

void BentContact::remember() {
  for (const PairPoint& pair : used()) {
    if (ContactMemory memory; memory_of(pair, memory)) points_->remember(memory);
    if (pair.now.acts && pair.now.pressure != 0.0)
      points_->note({.vertex = points_->number_of(pair.point),
                     .on_body = true,
                     .obstacle = obstacle_,
                     .position = pair.touch_a.x1,
                     .normal = pair.held.normal.normalized(),
                     .impulse = time().h * pair.now.force});
  }
}

std::size_t BentContact::acting() const {
  return static_cast<std::size_t>(std::count_if(
      used().begin(), used().end(), [](const PairPoint& pair) { return pair.now.acts; }));
}

}  // namespace tremolo
