#include "runtime/contact/joint.h"

namespace tremolo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// The spring without its length: its force, slope and energy.
JointForce spring_force(const Joint& joint, const Vector3d& middle, double l1) {
  const double k = joint.stiffness, L = joint.length;
  JointForce out;
  out.energy = 0.5 * k * (l1 - L) * (l1 - L);
  out.force = -k * middle;
  out.slope = (0.5 * k) * Matrix3d::Identity();
  return out;
}

}  // namespace

JointForce joint_force(const Joint& joint, const Vector3d& s0, const Vector3d& s1,
                       const Vector3d& turn, double h) {
  if (joint.length != 0.0) return joint_force_along(joint, s0, s1, h);
  const double c = joint.damping / h;
  const Vector3d middle = 0.5 * (s0 + s1);
  JointForce out = spring_force(joint, middle, s1.norm());
  const Vector3d w = s1 - s0 - turn.cross(middle);
  const Vector3d drag = -c * w;
  out.force += drag;
  out.torque = -0.5 * middle.cross(drag);
  out.slope.diagonal().array() += c;
  out.damped = c * w.squaredNorm();
  return out;
}

JointForce joint_force_along(const Joint& joint, const Vector3d& s0, const Vector3d& s1, double h) {
  const double k = joint.stiffness, L = joint.length, c = joint.damping / h;
  const Vector3d middle = 0.5 * (s0 + s1);
  const double l1 = s1.norm(), sum = s0.norm() + l1;
  JointForce out = spring_force(joint, middle, l1);
  if (!(sum > 0.0)) return out;
  out.force += (2.0 * k * L / sum) * middle;
  out.slope.diagonal().array() -= k * L / sum;
  if (l1 > 0.0) out.slope += (2.0 * k * L / (sum * sum * l1)) * middle * s1.transpose();
  const double length2 = middle.squaredNorm();
  if (!(length2 > 0.0)) return out;
  const double along = middle.dot(s1 - s0);
  out.force -= (c * along / length2) * middle;
  out.slope += (c / length2) * middle * middle.transpose();
  out.damped = c * along * along / length2;
  return out;
}

}  // namespace tremolo
