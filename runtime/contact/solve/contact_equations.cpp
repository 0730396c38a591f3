#include "runtime/contact/solve/contact_equations.h"

#include <cmath>
#include <limits>

#include "runtime/math/pose.h"

namespace tremolo {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d ContactEquations::place_in_body(std::size_t point, const VectorXd& q) const {
  const Vector3d from = points().rest[point] - motion.origin;
  return from + point_rows(point).transpose() * q;
}

ContactTouch ContactEquations::touch_at(const StepMotion& at, const Vector3d& rest,
                                        const PlaceRows& rows) const {
  const Vector3d from = rest - motion.origin;
  return at.touch(from + rows.transpose() * q0, from + rows.transpose() * q1);
}

ContactTouch ContactEquations::touch_at_point(std::size_t point) const {
  return motion_of(point).touch(place_in_body(point, q0), place_in_body(point, q1));
}

bool ContactEquations::follow_bones(const JointPlace& place, StepMotion& at) const {
  if (place.bones.empty()) return false;
  const StepMaps maps = bones->maps_of(place.bones);
  at.h = motion.h;
  at.modes = modes();
  at.origin.setZero();
  at.follow(maps.start, maps.end, bones->turn_of(place.bones));
  return true;
}

ContactTouch ContactEquations::straight_touch_at(const StepMotion& at,
                                                 const VertexRows& place) const {
  const Vector3d from = place.rest - motion.origin;
  return at.straight_touch(from + place.rows * q0, from + place.rows * q1);
}

Vector3d ContactEquations::end_of_point(std::size_t point) const {
  const StepMotion& at = motion_of(point);
  return at.c1 + at.R1 * place_in_body(point, q1);
}

Vector3d ContactEquations::bend_under(const StepMotion& at, const PlaceRows& rows) const {
  return at.turn_out(rows.transpose() * z.head(modes()));
}

void ContactEquations::clear_forces() {
  force.setZero();
  torque.setZero();
  pushed.setZero();
}

void ContactEquations::push(const StepMotion& at, const Vector3d& force_there,
                            const Vector3d& bend_force, const ContactTouch& touch,
                            const PlaceRows& rows) {
  pushed.noalias() += rows * (at.mean.transpose() * (at.R0.transpose() * bend_force));
  force += force_there;
  torque += touch.arm.cross(at.R0.transpose() * force_there);
}

void ContactEquations::add_turn_slopes(const Eigen::Ref<const Eigen::Matrix3Xd>& fall,
                                       Eigen::Ref<Eigen::MatrixXd> block) const {
  if (!turns()) return;
  block.middleRows<3>(modes()).noalias() +=
      motion.h * motion.turn.transpose() * motion.R0.transpose() * fall;
}

void ContactEquations::add_turn_geometry(const Vector3d& torque_alone) {
  if (!turns()) return;
  const Index r = modes();
  const Vector3d turned = motion.turn.transpose() * (motion.R0.transpose() * torque_alone);
  jacobian.block<3, 3>(r, r) -= motion.h * cross_matrix(turned) * motion.turned;
}

Eigen::Matrix3Xd ContactEquations::roll_slopes(const Vector3d& arm) const {
  Eigen::Matrix3Xd slopes = Eigen::Matrix3Xd::Zero(3, unknowns());
  if (turns()) slopes.middleCols<3>(modes()) = (-0.5 * motion.h) * cross_matrix(arm) * motion.R0;
  return slopes;
}

// For a position of the body itself, at which the force is `force_there`.
void ContactEquations::add_geometry(const Vector3d& force_there, const Vector3d& bend_force,
                                    const ContactTouch& touch, const PlaceRows& rows) {
  if (!turns()) return;
  add_turn(motion, force_there, bend_force, touch, rows, jacobian);
  jacobian.block(modes(), 0, 3, unknowns()).noalias() +=
      motion.turn_of_arm(force_there) * lever.swing();
}

void ContactEquations::add_geometry_at_point(const Vector3d& force_there, const ContactTouch& touch,
                                             std::size_t point) {
  if (!turns()) return;
  lever.make_swing(motion, touch, point_rows(point));
  add_geometry(force_there, force_there, touch, point_rows(point));
}

void ContactEquations::add_geometry_of_other(const Vector3d& force_there,
                                             const Vector3d& bend_force, const ContactTouch& touch,
                                             const PlaceRows& rows) {
  if (!turns()) return;
  const Index r = modes();
  add_turn(motion, force_there, bend_force, touch, rows, jacobian);
  jacobian.block<3, 3>(r, r + 3) -= 0.5 * motion.turn_of_arm(force_there) * motion.R0.transpose();
}

double ContactEquations::size_of_residual() const {
  const Index n = unknowns();
  return row_scale.head(n).cwiseProduct(residual.head(n)).norm();
}

double ContactEquations::work_along(const Eigen::Ref<const VectorXd>& move) const {
  const double h = motion.h;
  const Index r = modes();
  double work = 2.0 / (h * h) * residual.head(r).dot(move.head(r));
  if (turns()) {
    work += 0.5 * residual.segment<3>(r).dot(move.segment<3>(r));
    work += residual.segment<3>(r + 3).dot(move.segment<3>(r + 3));
  }
  return work;
}

double ContactEquations::way_of(const Eigen::Ref<const VectorXd>& move) const {
  const Index r = modes();
  const double way = move.head(r).cwiseAbs().dot(points().reach);
  if (!turns()) return way;
  const double turned = motion.h * points().radius * move.segment<3>(r).norm();
  return way + turned + move.segment<3>(r + 3).norm();
}

double ContactEquations::spring_rounding(const VertexRows& place, double stiffness,
                                         double far) const {
  const double lightness = place.rows.norm() + (turns() ? 1.0 / std::sqrt(surface.mass) : 0.0);
  return 4.0 * std::numeric_limits<double>::epsilon() * motion.h * stiffness * lightness *
         (far + points().extent);
}

}  // namespace tremolo
