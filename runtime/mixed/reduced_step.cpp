#include "runtime/mixed/reduced_step.h"

namespace tremolo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ContactStep& ReducedStep::step() const {
  return *body_->contact_;
}

const ContactStep& ReducedStep::contact() const {
  return *body_->contact_;
}

ContactEquations& ReducedStep::equations() const {
  return body_->contact_->equations();
}

bool ReducedStep::start(std::span<const PlacedCollider> colliders) {
  if (const std::optional<StepReport> failed = body_->begin_step()) {
    report_ = *failed;
    return false;
  }
  near_ = body_->near_something(colliders);
  return true;
}

void ReducedStep::step_alone() {
  report_ = body_->end_step(body_->advance_near(near_));
}

StepBall ReducedStep::ball() const {
  const ContactBall& ball = contact().ball();
  return {ball.centre, ball.radius + ball.deformed, ball.travel};
}

Vector3d ReducedStep::start_of(std::size_t point) const {
  return contact().poses().start * contact().points().place(point, equations().q0);
}

void ReducedStep::begin() {
  step().begin(body_->state_, body_->step_load_, body_->free_.get());
  levers_.resize(points());
}

void ReducedStep::go(double length, In direction) {
  const Eigen::Index n = unknowns();
  equations().z.head(n) = kept_.head(n) - length * direction;
}

void ReducedStep::evaluate(const ContactRenewal& renewal) {
  step().evaluate(renewal);
}

SiteMotion ReducedStep::motion(std::size_t point) const {
  const ContactTouch touch = equations().touch_at_point(point);
  return {touch.x0, touch.x1, equations().motion.middle_of(touch)};
}

void ReducedStep::add_force(std::size_t point, const Vector3d& force) {
  equations().push_point(force, equations().touch_at_point(point), point);
}

double ReducedStep::close() {
  return step().close();
}

void ReducedStep::residual(Out rows) const {
  rows = scale().cwiseProduct(equations().residual.head(unknowns()));
}

void ReducedStep::make_tangent(double heavier, bool follows) {
  step().make_jacobian(heavier, follows);
}

void ReducedStep::add_slope(std::size_t point, const Matrix3d& by_end, const Vector3d& force) {
  ContactEquations& eq = equations();
  const ContactTouch touch = eq.touch_at_point(point);
  eq.lever.make(eq.motion, touch, eq.point_rows(point));
  eq.lever.add_tangent(by_end, eq.jacobian);
  levers_[point].push = eq.lever.push();
  levers_[point].way = eq.lever.way();
  eq.add_geometry_at_point(force, touch, point);
}

bool ReducedStep::factor() {
  factor_.compute(equations().own_block());
  return true;
}

void ReducedStep::multiply(In x, Out rows) const {
  rows.noalias() = equations().own_block() * x;
  rows = rows.cwiseProduct(scale());
}

void ReducedStep::precondition(In rows, Out x) {
  x = factor_.solve(rows.cwiseQuotient(scale()));
}

Vector3d ReducedStep::change_at(std::size_t point, In x) const {
  return levers_[point].way * x;
}

void ReducedStep::add_image(std::size_t point, const Vector3d& fall, Out rows) const {
  rows += scale().cwiseProduct(levers_[point].push * fall);
}

bool ReducedStep::add_missed() {
  return step().add_missed();
}

void ReducedStep::finish(const ContactAccount& account, double start) {
  report_ = {};
  report_.converged = true;
  step().settle_pairs(account, start);
  step().finish(body_->state_, report_);
}

void ReducedStep::remember(const ContactMemory& memory) {
  step().remember_pair(memory);
}

void ReducedStep::end() {
  step().sort_pair_memories();
  body_->end_contact();
  report_ = body_->end_step(report_);
}

void ReducedStep::give_up() {
  report_ = {};
  report_.converged = false;
  report_ = body_->end_step(report_);
}

}  // namespace tremolo
