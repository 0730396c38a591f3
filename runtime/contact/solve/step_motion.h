// The motion of a body's frame in a step, and its effect on positions of the body (docs/theory.md,
// section "Contact"). The frame rotates from Ro0 to Ro1 = Ro0 cay(phi); Ro~ is the mean of the two.
#pragma once

#include <Eigen/Core>

#include "runtime/math/pose.h"
#include "runtime/math/state.h"
#include "runtime/parts.h"

namespace tremolo {

// A position of the body, or a grabbed vertex, at which a force acts.
struct ContactTouch {
  // The position at the ends of the step, m, world.
  Eigen::Vector3d x0 = Eigen::Vector3d::Zero(), x1 = x0;
  // Of the force about the centre, along the body's axes at the start, m.
  Eigen::Vector3d arm = x0;
};

// [F d] of a position F y + d, blended from the maps of several bones.
using BlendedMap = Eigen::Matrix<double, 3, 4>;

// The rows of U at a position, transposed, r x 3.
using PlaceRows = Eigen::Ref<const Eigen::MatrixX3d, 0, Eigen::OuterStride<>>;

// The rows of a vertex, which must stay in memory.
inline Eigen::Map<const Eigen::MatrixX3d> place_rows(const VertexRows& place) {
  return {place.rows.data(), place.rows.cols(), 3};
}

struct StepMotion {
  double h = 0.0;          // the step, s
  Eigen::Index modes = 0;  // r
  bool free = false;       // omega1 and the centre's path are unknowns r .. r + 5

  Eigen::Matrix3d R0 = Eigen::Matrix3d::Identity(), R1 = R0;  // Ro0, Ro1
  Eigen::Matrix3d turn = R0;                                  // Ro0^T Ro1
  Eigen::Matrix3d mean = R0;                                  // Ro0^T Ro~
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();              // cay(phi) is turn
  // Rotation of the end, along its own axes, per change of omega1.
  Eigen::Matrix3d turned = Eigen::Matrix3d::Zero();
  Eigen::Vector3d c0 = phi, c1 = phi;  // mesh origin, or centre of mass of a free body, m, world
  Eigen::Vector3d origin = phi;        // c in the mesh's coordinates, m
  // Of a point on several bones, whose phi is zero: their mean rotation, rad, world.
  bool blended = false;
  Eigen::Vector3d bones_turn = phi;

  Eigen::Index unknowns() const { return modes + (turns() ? 6 : 0); }
  bool turns() const { return kHasFrames && free; }

  // Sets the motion between two poses.
  void follow(const StepPoses& poses);
  // Sets the motion of a point on several bones, F y + d, from [F d] at both ends. F is their mean
  // rotation and shrinks where they differ: Ro0, Ro1 and Ro~ are F0, F1 and their mean. It has no
  // turn and no phi. turn_of_bones: is turn_in_step(), which joints use.
  void follow(const BlendedMap& start, const BlendedMap& end,
              const Eigen::Vector3d& turn_of_bones = Eigen::Vector3d::Zero());
  // Sets R1 and all values that follow from the rotation.
  void set_turn(const Eigen::Matrix3d& turn_in_step);

  // y0, y1: the position from c along the body's axes, at the ends of the step, m.
  ContactTouch touch(const Eigen::Vector3d& y0, const Eigen::Vector3d& y1) const {
    return {c0 + R0 * y0, c1 + R1 * y1, mean * (0.5 * (y0 + y1))};
  }
  // The same, with the force at the straight mean of the ends. The force that deforms the body is
  // then straight_bend() of the force, so that its work is F.(x1 - x0) exactly.
  ContactTouch straight_touch(const Eigen::Vector3d& y0, const Eigen::Vector3d& y1) const;
  Eigen::Vector3d straight_bend(const Eigen::Vector3d& force) const;
  // The position of another body's point, which ends at x1 and has the mean position `middle`, m,
  // world.
  ContactTouch touch_by_other(const Eigen::Vector3d& x1, const Eigen::Vector3d& middle) const {
    return {x1, x1, R0.transpose() * (middle - 0.5 * (c0 + c1))};
  }
  // The mean position, about which a force's torque is taken, m, world.
  Eigen::Vector3d middle_of(const ContactTouch& touch) const {
    return 0.5 * (c0 + c1) + R0 * touch.arm;
  }
  // Displacement of such a position in the step with the body rigid, m, world.
  Eigen::Vector3d way_under(const ContactTouch& touch) const {
    return (c1 - c0) + R0 * phi.cross(touch.arm);
  }
  // The rotation whose product with a torque is its work, rad, world.
  Eigen::Vector3d turn_in_step() const { return blended ? bones_turn : Eigen::Vector3d(R0 * phi); }
  // Converts a position of the world to the mesh's coordinates, at the start or the end of the
  // step.
  Eigen::Vector3d into_rest(const Eigen::Vector3d& x, bool at_end) const {
    return (at_end ? R1 : R0).transpose() * (x - (at_end ? c1 : c0)) + origin;
  }
  // Rotates a direction of those coordinates to the world, in the middle, and at the end.
  Eigen::Vector3d turn_out(const Eigen::Vector3d& n) const { return R0 * (mean * n); }
  Eigen::Vector3d turn_out_at_end(const Eigen::Vector3d& n) const { return R1 * n; }
  // The rotation half-way between Ro0 and Ro1.
  Eigen::Matrix3d halfway() const;
  // Derivative of omega1's residual with respect to an arm along the body's axes at the start, at
  // which `force` (N, world) acts.
  Eigen::Matrix3d turn_of_arm(const Eigen::Vector3d& force) const;
};

// The effect of a force at one position on the equations of its body, and the motion of the
// position with the unknowns. It is made for one position at a time. n = r, or r + 6 for a body
// that rotates.
class PlaceLever {
 public:
  explicit PlaceLever(Eigen::Index modes);

  // Makes the lever of a position. push(): derivative by which the residual falls with a force
  // there. way(): derivative of its end with respect to the unknowns.
  void make(const StepMotion& motion, const ContactTouch& touch, const PlaceRows& rows);
  auto push() const { return push_.topRows(n_); }  // n x 3
  auto way() const { return way_.leftCols(n_); }   // 3 x n

  // Adds to the Jacobian the effect of a force that falls with the position's end by `stiffness`,
  // N/m.
  void add_tangent(const Eigen::Matrix3d& stiffness, Eigen::MatrixXd& jacobian);
  // Adds to the n rows of `block` the effect on the residual of a change of the force at the
  // position and of the force that deforms the body there: 3 rows each and the block's columns,
  // times the sign.
  void add_pushed(const Eigen::Matrix3Xd& change, const Eigen::Matrix3Xd& bend_change, double sign,
                  Eigen::Ref<Eigen::MatrixXd> block) const;

  // Makes swing(), the derivative of the arm of the body's own position, 3 x n. The second is for
  // an arm of straight_touch(), after make().
  void make_swing(const StepMotion& motion, const ContactTouch& touch, const PlaceRows& rows);
  void make_straight_swing(const StepMotion& motion);
  auto swing() const { return swing_.leftCols(n_); }
  // Derivative of middle_of() at the position of swing(), 3 x n.
  const Eigen::Matrix3Xd& path_of_middle(const StepMotion& motion);
  // Approximate derivatives of the deformation at a position (the first r columns) and of
  // way_under() (the others), 3 x n; of more columns the first n.
  const Eigen::Matrix3Xd& change_of_way(const StepMotion& motion, const ContactTouch& touch,
                                        const PlaceRows& rows);

 private:
  Eigen::Index n_ = 0;
  Eigen::MatrixXd push_;    // n x 3
  Eigen::MatrixXd pushed_;  // push_ times a stiffness
  Eigen::MatrixXd way_;     // 3 x n
  Eigen::Matrix3Xd swing_;  // 3 x n
  Eigen::Matrix3Xd path_;   // 3 x n
};

// Adds to the Jacobian the change of the residual because a force (N, world) at the position
// rotates with the body. bend_force: the force that deforms the body, N.
void add_turn(const StepMotion& motion, const Eigen::Vector3d& force,
              const Eigen::Vector3d& bend_force, const ContactTouch& touch, const PlaceRows& rows,
              Eigen::MatrixXd& jacobian);

}  // namespace tremolo
