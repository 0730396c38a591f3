// A joint: a spring and a damper between places of two bodies (docs/theory.md, section "Contact").
//
// With s the way from the second place to the first, s~ the mean of its ends in a step and l its
// length, the force on the first place is
//
//     F = -k (1 - 2 L/(l0 + l1)) s~,   F.(s1 - s0) = V0 - V1,   V = k/2 (l - L)^2
//
// along s~, so that the joint keeps both momenta and its energy is V exactly. The damper of a joint
// without length acts on w = s1 - s0 - theta x s~, theta the mean turn of the two bodies, with both
// its forces in the middle of s~; that of a joint with length along s~ alone.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/values/vertex_rows.h"

namespace tremolo {

// stiffness: N/m, and damping: N s/m; without a stiffness both follow from the masses with which
// the places resist and the step, as those of Body::pin(). length: L, m. touch: the two bodies
// touch each other all the same.
struct JointOptions {
  std::optional<double> stiffness;
  double damping = 0.0;
  double length = 0.0;
  bool touch = false;
};

// first, second: the places, each in the mesh's coordinates of its body. stiffness: k, N/m;
// damping: N s/m; length: L, m. touch: the two bodies touch each other all the same. force: on the
// first place in the last step, N, world. energy: V at its end, J. damped: what the
// damper took since the start, J.
struct Joint {
  VertexRows first, second;
  double stiffness = 0.0;
  double damping = 0.0;
  double length = 0.0;
  bool touch = false;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double energy = 0.0;
  double damped = 0.0;

  void carry(StateStream& stream) { stream(force, energy, damped); }
};

// What a joint does in a step, for separations s0 and s1 at its ends, m, world. force: on the first
// place, N, its opposite on the second. torque: on each of the two bodies besides, N m. slope: by
// how much the force falls with s1, nearly, N/m. energy: V at the end; damped: taken, J.
struct JointForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
  double energy = 0.0;
  double damped = 0.0;
};

// turn: theta, world, of Cayley's length; h: the step, s.
JointForce joint_force(const Joint& joint, const Eigen::Vector3d& s0, const Eigen::Vector3d& s1,
                       const Eigen::Vector3d& turn, double h);

}  // namespace tremolo
