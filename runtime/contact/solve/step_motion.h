// How the frame of a body goes through a step, and what that means for places of the body
// (docs/theory.md, section "Contact"). The frame turns from Ro0 to Ro1 = Ro0 cay(phi); Ro~ is the
// mean of the two.
#pragma once

#include <Eigen/Core>

#include "runtime/parts.h"
#include "runtime/values/vertex_rows.h"

namespace tremolo {

// What a force on a place of the body, or on a hand's vertex, does. x0, x1: where it is at the ends
// of the step, m, world. arm: of the force about the centre, along the body's axes at the start.
struct ContactTouch {
  Eigen::Vector3d x0 = Eigen::Vector3d::Zero(), x1 = x0;
  Eigen::Vector3d arm = x0;
};

// The rows of U of a place, transposed, r x 3.
using PlaceRows = Eigen::Ref<const Eigen::MatrixX3d, 0, Eigen::OuterStride<>>;

// Those of a vertex, which must stay where they are.
inline Eigen::Map<const Eigen::MatrixX3d> place_rows(const VertexRows& place) {
  return {place.rows.data(), place.rows.cols(), 3};
}

struct StepMotion {
  double h = 0.0;          // the step, s
  Eigen::Index modes = 0;  // r
  bool free = false;       // free: omega1 and the centre's path are unknowns r .. r + 5

  Eigen::Matrix3d R0, R1;  // Ro0, Ro1
  Eigen::Matrix3d turn;    // Ro0^T Ro1
  Eigen::Matrix3d mean;    // Ro0^T Ro~
  Eigen::Vector3d phi;     // cay(phi) is turn
  Eigen::Matrix3d turned;  // how the end turns, along its own axes, with omega1
  Eigen::Vector3d c0, c1;  // of the mesh's origin, or of a free body's centre of mass, m, world
  Eigen::Vector3d origin;  // in the mesh's coordinates, of c

  Eigen::Index unknowns() const { return modes + (turns() ? 6 : 0); }
  bool turns() const { return kHasFrames && free; }

  // Sets R1 and what follows from turn.
  void set_turn(const Eigen::Matrix3d& turn_in_step);

  // y0, y1: of the place from c along the body's axes, at the ends of the step.
  ContactTouch touch(const Eigen::Vector3d& y0, const Eigen::Vector3d& y1) const {
    return {c0 + R0 * y0, c1 + R1 * y1, mean * (0.5 * (y0 + y1))};
  }
  // The same with the straight mean of the ends as the place of the force. What bends the body is
  // then straight_bend() of the force, so that its work is F.(x1 - x0) exactly.
  ContactTouch straight_touch(const Eigen::Vector3d& y0, const Eigen::Vector3d& y1) const;
  Eigen::Vector3d straight_bend(const Eigen::Vector3d& force) const;
  // A place of another body's point, which ends at x1 and whose mean place is `middle`, m, world.
  ContactTouch touch_by_other(const Eigen::Vector3d& x1, const Eigen::Vector3d& middle) const {
    return {x1, x1, R0.transpose() * (middle - 0.5 * (c0 + c1))};
  }
  // The mean place about which a force's torque is taken, m, world.
  Eigen::Vector3d middle_of(const ContactTouch& touch) const {
    return 0.5 * (c0 + c1) + R0 * touch.arm;
  }
  // By how much such a place moves in the step with the body as it is, m, world.
  Eigen::Vector3d way_under(const ContactTouch& touch) const {
    return (c1 - c0) + R0 * phi.cross(touch.arm);
  }
  // A place of the world in the mesh's coordinates, at the start or the end of the step.
  Eigen::Vector3d into_rest(const Eigen::Vector3d& x, bool at_end) const {
    return (at_end ? R1 : R0).transpose() * (x - (at_end ? c1 : c0)) + origin;
  }
  // A direction of those coordinates in the world, in the middle, and at the end.
  Eigen::Vector3d turn_out(const Eigen::Vector3d& n) const { return R0 * (mean * n); }
  Eigen::Vector3d turn_out_at_end(const Eigen::Vector3d& n) const { return R1 * n; }
  // The rotation half-way between Ro0 and Ro1.
  Eigen::Matrix3d halfway() const;
  // How the residual of omega1 changes with an arm along the body's axes at the start, on which
  // `force` (N, world) acts.
  Eigen::Matrix3d turn_of_arm(const Eigen::Vector3d& force) const;
};

// What a force on one place does to the equations of its body, and how the place moves with the
// unknowns; one place after the other. n = r, or r + 6 of a body that turns.
class PlaceLever {
 public:
  explicit PlaceLever(Eigen::Index modes);

  // The lever of a place: push(), how the residual falls with a force on it, and way(), how its end
  // moves.
  void make(const StepMotion& motion, const ContactTouch& touch, const PlaceRows& rows);
  auto push() const { return push_.topRows(n_); }  // n x 3
  auto way() const { return way_.leftCols(n_); }   // 3 x n

  // Adds to the Jacobian what a force that falls with the place's end by `stiffness`, N/m, adds.
  void add_tangent(const Eigen::Matrix3d& stiffness, Eigen::MatrixXd& jacobian);
  // Adds to the n rows of `block` what a change of the force on the place, and of what bends the
  // body there, does to the residual: 3 rows each and the block's columns, times the sign.
  void add_pushed(const Eigen::Matrix3Xd& change, const Eigen::Matrix3Xd& bend_change, double sign,
                  Eigen::Ref<Eigen::MatrixXd> block) const;

  // swing(): how the arm of a place of the body's own moves with the unknowns, 3 x n; of one whose
  // arm is that of straight_touch(), after make().
  void make_swing(const StepMotion& motion, const ContactTouch& touch, const PlaceRows& rows);
  void make_straight_swing(const StepMotion& motion);
  auto swing() const { return swing_.leftCols(n_); }
  // How middle_of() the place of swing() moves, 3 x n.
  const Eigen::Matrix3Xd& path_of_middle(const StepMotion& motion);
  // How the bending at a place (the first r columns) and way_under() (the others) change with the
  // unknowns, nearly, 3 x n (of more columns the first).
  const Eigen::Matrix3Xd& change_of_way(const StepMotion& motion, const ContactTouch& touch,
                                        const PlaceRows& rows);

 private:
  Eigen::Index n_ = 0;
  Eigen::MatrixXd push_;    // n x 3
  Eigen::MatrixXd pushed_;  // that times a stiffness
  Eigen::MatrixXd way_;     // 3 x n
  Eigen::Matrix3Xd swing_;  // 3 x n
  Eigen::Matrix3Xd path_;   // 3 x n
};

// Adds to the Jacobian how the residual changes as a force (N, world) on the place turns with the
// body; bend_force: what bends it.
void add_turn(const StepMotion& motion, const Eigen::Vector3d& force,
              const Eigen::Vector3d& bend_force, const ContactTouch& touch, const PlaceRows& rows,
              Eigen::MatrixXd& jacobian);

}  // namespace tremolo
