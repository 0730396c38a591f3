// Pose of a body's frame: x = position + rotation (X + u), X and u as in the mesh.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/state_stream.h"

namespace tremolo {

// A position and a rotation in the world.
struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            // of the mesh's origin, m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // of length one

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return position + rotation * x; }
};

inline void carry(StateStream& stream, Pose& pose) {
  stream(pose.position, pose.rotation);
}

// The matrix of a x: cross_matrix(a) b = a x b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

// cay(phi) = (I - [phi]/2)^-1 (I + [phi]/2), a rotation about phi by 2 atan(|phi|/2).
inline Eigen::Quaterniond cayley(const Eigen::Vector3d& phi) {
  return Eigen::Quaterniond(1.0, 0.5 * phi.x(), 0.5 * phi.y(), 0.5 * phi.z()).normalized();
}
inline Eigen::Matrix3d cayley_matrix(const Eigen::Vector3d& phi) {
  const Eigen::Matrix3d hat = cross_matrix(phi);
  return Eigen::Matrix3d::Identity() + (hat + 0.5 * hat * hat) / (1.0 + 0.25 * phi.squaredNorm());
}

// The rotation about phi by |phi|, and the phi of a rotation, |phi| <= pi.
inline Eigen::Quaterniond turn_by(const Eigen::Vector3d& phi) {
  const double half = 0.5 * phi.norm();
  // sin(half)/|phi|, by its series where |phi| is small.
  const double share = half < 1e-4 ? 0.5 - half * half / 12.0 : 0.5 * std::sin(half) / half;
  return Eigen::Quaterniond(std::cos(half), share * phi.x(), share * phi.y(), share * phi.z());
}
inline Eigen::Vector3d turn_of(const Eigen::Quaterniond& turn) {
  const double sine = turn.vec().norm();
  const double sign = turn.w() < 0.0 ? -1.0 : 1.0;
  if (sine == 0.0) return Eigen::Vector3d::Zero();
  return (sign * 2.0 * std::atan2(sine, sign * turn.w()) / sine) * turn.vec();
}

// The pose at a fraction of the way between two: a straight line, and a rotation about one axis.
inline Pose pose_between(const Pose& start, const Pose& end, double fraction) {
  return {start.position + fraction * (end.position - start.position),
          start.rotation.slerp(fraction, end.rotation)};
}

// Poses of the body's mesh frame in the step. For a free body `end` is a prediction.
struct StepPoses {
  Pose start, end;
};

}  // namespace tremolo
