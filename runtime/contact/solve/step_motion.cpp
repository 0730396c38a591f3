#include "runtime/contact/solve/step_motion.h"

#include <cmath>

#include "runtime/math/dense/decompositions.h"
#include "runtime/math/pose.h"

namespace tremolo {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

void StepMotion::follow(const StepPoses& poses) {
  R0 = poses.start.rotation.toRotationMatrix();
  c0 = poses.start.position;
  set_turn(R0.transpose() * poses.end.rotation.toRotationMatrix());
  const Eigen::Quaterniond by = poses.start.rotation.conjugate() * poses.end.rotation;
  phi = 2.0 / by.w() * by.vec();
  c1 = poses.end.position;
}

void StepMotion::follow(const BlendedMap& start, const BlendedMap& end,
                        const Vector3d& turn_of_bones) {
  constexpr double kFlat = 1e-4;  // of the volume that F leaves
  R0 = start.leftCols<3>();
  R1 = end.leftCols<3>();
  c0 = start.col(3);
  c1 = end.col(3);
  const Matrix3d half = 0.5 * (R0 + R1);
  if (std::abs(R0.determinant()) > kFlat)
    mean = R0.inverse() * half;
  else
    mean = solve_shortest(R0, half);
  turn.setIdentity();
  phi.setZero();
  blended = true;
  bones_turn = turn_of_bones;
}

void StepMotion::set_turn(const Matrix3d& turn_in_step) {
  turn = turn_in_step;
  R1 = R0 * turn;
  mean = 0.5 * (Matrix3d::Identity() + turn);
}

// (x0 + x1)/2 differs from the mean position by (Ro1 - Ro0)(y1 - y0)/4.
ContactTouch StepMotion::straight_touch(const Vector3d& y0, const Vector3d& y1) const {
  const Vector3d turned_mean = 0.5 * (y0 + turn * y1);
  return {c0 + R0 * y0, c1 + R1 * y1, turned_mean};
}

// The displacement of the position is way_under() of that arm plus Ro0 (mean - phi x (turn -
// 1)/4)(y1 - y0), where turn - 1 = phi x mean. On several bones F is no rotation; what is the same
// for bones that move together is said along the axes of the world.
Vector3d StepMotion::straight_bend(const Vector3d& force) const {
  if (blended) return force - 0.25 * bones_turn.cross(bones_turn.cross(force));
  const Vector3d pull = R0.transpose() * force;
  return R0 * (pull - 0.25 * phi.cross(phi.cross(pull)));
}

Matrix3d StepMotion::halfway() const {
  const Eigen::Quaterniond whole = Eigen::Quaterniond(2.0, phi.x(), phi.y(), phi.z()).normalized();
  const Eigen::Quaterniond half =
      Eigen::Quaterniond(1.0 + whole.w(), whole.x(), whole.y(), whole.z()).normalized();
  return R0 * half.toRotationMatrix();
}

Matrix3d StepMotion::turn_of_arm(const Vector3d& force) const {
  return h * turn.transpose() * cross_matrix(R0.transpose() * force);
}

PlaceLever::PlaceLever(Index modes)
    : push_(Eigen::MatrixXd::Zero(modes + 6, 3)),
      pushed_(push_),
      way_(Eigen::MatrixXd::Zero(3, modes + 6)),
      swing_(Eigen::Matrix3Xd::Zero(3, modes + 6)),
      path_(swing_) {}

void PlaceLever::make(const StepMotion& motion, const ContactTouch& touch, const PlaceRows& rows) {
  const double h = motion.h;
  const Index r = motion.modes;
  n_ = motion.unknowns();
  // For so few columns the packing of a large product takes longer than it saves.
  way_.leftCols(r).noalias() = motion.R1.lazyProduct(rows.transpose());
  const Matrix3d into_body = (0.5 * h * h) * (motion.R0 * motion.mean).transpose();
  push_.topRows(r).noalias() = rows.lazyProduct(into_body);
  if (!motion.turns()) return;
  const Vector3d y1 = motion.R1.transpose() * (touch.x1 - motion.c1);
  way_.middleCols<3>(r) = -motion.R1 * cross_matrix(y1) * motion.turned;
  way_.rightCols<3>().setIdentity();
  push_.middleRows<3>(r) =
      h * motion.turn.transpose() * cross_matrix(touch.arm) * motion.R0.transpose();
  push_.bottomRows<3>().setIdentity();
}

void PlaceLever::add_tangent(const Matrix3d& stiffness, Eigen::MatrixXd& jacobian) {
  pushed_.topRows(n_).noalias() = push_.topRows(n_).lazyProduct(stiffness);
  // Column by column: three multiply-adds along each.
  for (Index j = 0; j < n_; ++j)
    jacobian.col(j).head(n_) += pushed_.col(0).head(n_) * way_(0, j) +
                                pushed_.col(1).head(n_) * way_(1, j) +
                                pushed_.col(2).head(n_) * way_(2, j);
}

void PlaceLever::add_pushed(const Eigen::Matrix3Xd& change, const Eigen::Matrix3Xd& bend_change,
                            double sign, Eigen::Ref<Eigen::MatrixXd> block) const {
  const Index r = push_.rows() - 6;
  // Three multiply-adds along each column: too few for the packing of a large product.
  for (Index j = 0; j < block.cols(); ++j) {
    const Vector3d bend = sign * bend_change.col(j);
    block.col(j).head(r) += push_.col(0).head(r) * bend[0] + push_.col(1).head(r) * bend[1] +
                            push_.col(2).head(r) * bend[2];
  }
  if (n_ > r) block.bottomRows<6>().noalias() += sign * push_.bottomRows<6>().lazyProduct(change);
}

void PlaceLever::make_swing(const StepMotion& motion, const ContactTouch& touch,
                            const PlaceRows& rows) {
  const Index r = motion.modes;
  n_ = motion.unknowns();
  swing_.leftCols(r).noalias() = (0.5 * motion.mean) * rows.transpose();
  if (!motion.turns()) return;
  const Vector3d y0 = motion.R0.transpose() * (touch.x0 - motion.c0);
  const Vector3d y1 = motion.R1.transpose() * (touch.x1 - motion.c1);
  swing_.middleCols<3>(r) = -0.25 * motion.turn * cross_matrix(y0 + y1) * motion.turned;
  swing_.rightCols<3>().setZero();
}

void PlaceLever::make_straight_swing(const StepMotion& motion) {
  swing_.leftCols(n_).noalias() = (0.5 * motion.R0.transpose()) * way_.leftCols(n_);
  if (motion.turns()) swing_.rightCols<3>().setZero();
}

const Eigen::Matrix3Xd& PlaceLever::path_of_middle(const StepMotion& motion) {
  path_.noalias() = motion.R0 * swing_;
  if (motion.turns()) path_.rightCols<3>() += 0.5 * Matrix3d::Identity();
  return path_;
}

const Eigen::Matrix3Xd& PlaceLever::change_of_way(const StepMotion& motion,
                                                  const ContactTouch& touch,
                                                  const PlaceRows& rows) {
  const Index r = motion.modes;
  path_.leftCols(r).noalias() = (motion.R0 * motion.mean) * rows.transpose();
  if (!motion.turns()) return path_;
  path_.middleCols<3>(r) = (-0.5 * motion.h) * motion.R0 * cross_matrix(touch.arm);
  path_.rightCols<3>().setIdentity();
  return path_;
}

void add_turn(const StepMotion& motion, const Vector3d& force, const Vector3d& bend_force,
              const ContactTouch& touch, const PlaceRows& rows, Eigen::MatrixXd& jacobian) {
  if (!motion.turns()) return;
  const double h = motion.h;
  const Index r = motion.modes;
  const Vector3d pull = motion.R0.transpose() * force;
  const Vector3d bend_pull = motion.R0.transpose() * bend_force;
  const Matrix3d turned_back = motion.turn.transpose();
  jacobian.block<3, 3>(r, r) -=
      h * cross_matrix(turned_back * touch.arm.cross(pull)) * motion.turned;
  const Matrix3d turned_pull = cross_matrix(turned_back * bend_pull) * motion.turned;
  jacobian.block(0, r, r, 3).noalias() -= (0.25 * h * h) * rows * turned_pull;
}

}  // namespace tremolo
