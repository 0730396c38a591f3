#include "runtime/mixed/reduced_step.h"

namespace tremolo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

StepBall ReducedStep::ball() const {
  const ContactBall& ball = contact().gathered().ball;
  return {ball.centre, ball.radius + ball.deformed, ball.travel};
}

Vector3d ReducedStep::start_of(std::size_t point) const {
  return contact().start_of_point(point);
}

void ReducedStep::begin() {
  contact().begin(*member_.state, *member_.load, member_.free);
  if (levers_.size() < points()) levers_.resize(points());
}

void ReducedStep::go(double length, In direction) {
  const Eigen::Index n = unknowns();
  equations().z.head(n) = kept_.head(n) - length * direction;
}

SiteMotion ReducedStep::motion(std::size_t point) const {
  const ContactTouch touch = equations().touch_at_point(point);
  return {touch.x0, touch.x1, equations().motion_of(point).middle_of(touch)};
}

void ReducedStep::add_force(std::size_t point, const Vector3d& force) {
  equations().push_point(force, equations().touch_at_point(point), point);
}

void ReducedStep::residual(Out rows) const {
  rows = scale().cwiseProduct(equations().residual.head(unknowns()));
}

void ReducedStep::make_tangent(double heavier, bool follows) {
  contact().make_jacobian(heavier, follows);
}

void ReducedStep::add_slope(std::size_t point, const Matrix3d& by_end, const Vector3d& force) {
  ContactEquations& eq = equations();
  const ContactTouch touch = eq.touch_at_point(point);
  eq.lever.make(eq.motion_of(point), touch, eq.point_rows(point));
  eq.lever.add_tangent(by_end, eq.jacobian);
  levers_[point].push = eq.lever.push();
  levers_[point].way = eq.lever.way();
  eq.add_geometry_at_point(force, touch, point);
}

bool ReducedStep::factor(bool fresh) {
  (void)fresh;  // it is small
  factor_.compute(equations().own_block());
  return true;
}

void ReducedStep::multiply(In x, Out rows) const {
  rows.noalias() = equations().own_block() * x;
  rows = rows.cwiseProduct(scale());
}

void ReducedStep::precondition(In rows, Out x) {
  rows_ = rows.cwiseQuotient(scale());
  x = rows_;
  factor_.solve_in_place(x);
}

Vector3d ReducedStep::change_at(std::size_t point, In x) const {
  return levers_[point].way * x;
}

void ReducedStep::add_image(std::size_t point, const Vector3d& fall, Out rows) const {
  add_scaled(levers_[point].push, fall, rows);
}

void ReducedStep::add_scaled(const Eigen::MatrixXd& push, const Vector3d& fall, Out rows) const {
  rows += scale().cwiseProduct(push.lazyProduct(fall));
}

void ReducedStep::finish(const ContactAccount& account, double start, bool jumped) {
  report_ = {};
  report_.converged = true;
  contact().finish(*member_.state, report_, account, start);
  if (jumped) contact().record().account.give_surplus();
}

}  // namespace tremolo
