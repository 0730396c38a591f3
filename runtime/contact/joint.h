// A joint: a spring and a damper between points of two bodies (docs/theory.md, section "Contact").
//
// Let s be the vector from the second point to the first, s~ the mean of its ends in a step and l
// its length. The force on the first point is
//
//     F = -k (1 - 2 L/(l0 + l1)) s~,   F.(s1 - s0) = V0 - V1,   V = k/2 (l - L)^2
//
// along s~, so that the joint conserves both momenta and its energy is V exactly. The damper of a
// joint without length acts on w = s1 - s0 - theta x s~, where theta is the mean rotation of the
// two bodies; both its forces act in the middle of s~. The damper of a joint with length acts along
// s~ alone.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/math/state.h"

namespace tremolo {

// Options of a joint.
struct JointOptions {
  // k, N/m. Without it, stiffness and damping follow from the effective masses of the points and
  // the step, same as for Body::pin().
  std::optional<double> stiffness;
  double damping = 0.0;  // N s/m
  double length = 0.0;   // L, m
  bool touch = false;    // contact between the two bodies continues
  // Mass that the joint may have to carry, kg. The stiffest spring is as stiff as for a pair of
  // points with a hundredth of it, if they are lighter.
  double load = 0.0;
};

// A point of a body that a joint holds.
struct JointPlace : VertexRows {
  // Of a body on several bones: how much each of them moves the point, with sum 1; else empty.
  std::vector<double> bones;
};

// A joint, with its force and energy.
struct Joint {
  // The joined points, each in the mesh's coordinates of its body.
  JointPlace first, second;
  double stiffness = 0.0;  // k, N/m
  double damping = 0.0;    // N s/m
  double length = 0.0;     // L, m
  bool touch = false;      // contact between the two bodies continues
  // On the first point in the last step, N, world.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double energy = 0.0;  // V at the end of the last step, J
  double damped = 0.0;  // taken by the damper since the start, J

  void carry(StateStream& stream) { stream(force, energy, damped); }
};

// Adds a joint of a weld to its sums, which have no positions.
inline void add_joint(Joint& sum, const Joint& joint) {
  sum.stiffness += joint.stiffness;
  sum.damping += joint.damping;
  sum.force += joint.force;
  sum.energy += joint.energy;
  sum.damped += joint.damped;
}

// Forces and energies of a joint in a step, for separations s0 and s1 at its ends, m, world.
struct JointForce {
  // On the first point, N; its opposite acts on the second.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  // In addition, on each of the two bodies, N m.
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  // Approximate derivative by which the force falls with s1, N/m.
  Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
  double energy = 0.0;  // V at the end, J
  double damped = 0.0;  // taken by the damper, J
};

// turn: theta, world, with the length of Cayley's formula; h: the step, s.
JointForce joint_force(const Joint& joint, const Eigen::Vector3d& s0, const Eigen::Vector3d& s1,
                       const Eigen::Vector3d& turn, double h);
// The same of a joint whose damper acts along s~ alone, whether it has a length or not.
JointForce joint_force_along(const Joint& joint, const Eigen::Vector3d& s0,
                             const Eigen::Vector3d& s1, double h);

}  // namespace tremolo
