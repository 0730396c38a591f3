// The equations of a body in a step with contact (contact_step.h), and the effect of forces at
// positions of the body on them. A force F on the position y = X + U q adds f = U^T Ro~^T F and the
// torque (Ro~ y~) x F, so that the work of F is F.(x1 - x0) exactly.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/reduced/bones/bone_points.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_surface.h"
#include "runtime/contact/solve/step_motion.h"
#include "runtime/math/state.h"

namespace tremolo {

// n = unknowns() rows are used: d = q1 - q0 and, for a free body, omega1 and the path e of its
// centre.
struct ContactEquations {
  ContactSurface surface;
  StepMotion motion;  // of the frame, at the present z; of the first of several bones
  // Of a body on several bones: its contact points in the step, and the motion of each; null: it
  // has one frame.
  FrameSharer<BonePoints> bones;
  std::vector<StepMotion> point_motions;
  PlaceLever lever;           // effect of a force at one position
  Eigen::VectorXd q0, q1;     // coordinates at the ends of the step, r
  Eigen::VectorXd u0, u1;     // displacements of the points there; of a body with a shape
  Eigen::VectorXd z;          // unknowns, r + 6
  Eigen::VectorXd residual;   // kg^1/2 m for d, N m s for omega1, N for e; r + 6
  Eigen::VectorXd row_scale;  // converts the residual's rows to momenta, kg^1/2 m/s; r + 6
  Eigen::MatrixXd jacobian;   // of the residual, (r + 6) x (r + 6)
  // Sums of the forces at positions: on the coordinates, r; on the centre, N, world; and their
  // torque about it, N m, along the body's axes at the start.
  Eigen::VectorXd pushed;
  Eigen::Vector3d force, torque;

  explicit ContactEquations(ContactSurface body_surface, Eigen::Index modes)
      : surface(std::move(body_surface)), lever(modes) {}

  const ContactPoints& points() const { return *surface.points; }
  Eigen::Index modes() const { return motion.modes; }
  Eigen::Index unknowns() const { return motion.unknowns(); }
  bool turns() const { return motion.turns(); }
  auto own_block() { return jacobian.topLeftCorner(unknowns(), unknowns()); }

  // The rows of U of a contact point, transposed, r x 3.
  auto point_rows(std::size_t point) const {
    return points().rows.middleCols<3>(static_cast<Eigen::Index>(3 * point));
  }
  // The motion that a contact point follows.
  const StepMotion& motion_of(std::size_t point) const {
    return bones ? point_motions[point] : motion;
  }
  // A position of the world in the mesh's coordinates, at the end of the step, m.
  Eigen::Vector3d into_rest_at_end(const Eigen::Vector3d& x) const {
    return bones ? bones->into_rest(x, true) : motion.into_rest(x, true);
  }
  // Position of a contact point from c along the body's axes, m.
  Eigen::Vector3d place_in_body(std::size_t point, const Eigen::VectorXd& q) const;
  // A position of the body in the step, which follows `at`. rest: in the mesh's coordinates, m.
  ContactTouch touch_at(const StepMotion& at, const Eigen::Vector3d& rest,
                        const PlaceRows& rows) const;
  ContactTouch touch_at_point(std::size_t point) const;
  // Sets the motion of a joint's place on several bones; false: the place follows `motion`.
  bool follow_bones(const JointPlace& place, StepMotion& at) const;
  // The position of a joint's place, which follows `at`; the force acts at the straight mean of its
  // ends.
  ContactTouch straight_touch_at(const StepMotion& at, const VertexRows& place) const;
  Eigen::Vector3d end_of_point(std::size_t point) const;  // its x1
  // Displacement in the step of a position, whose rows of U are `rows`, by deformation, m, world.
  // at: the motion that the position follows. The work of a force is its product with that plus
  // at.way_under().
  Eigen::Vector3d bend_under(const StepMotion& at, const PlaceRows& rows) const;
  // Bound of the displacement of any point by the coordinates in the step, m.
  double bend_in_step() const { return z.head(modes()).cwiseAbs().dot(points().reach); }
  // The shape, deformed as at the start or the end of the step.
  // side: of the point in question.
  BentShape shape_at_start(const EntrySide& side = {}) const {
    return {&*surface.shape, surface.points.get(), &u0, side};
  }
  BentShape shape_at_end(const EntrySide& side = {}) const {
    return {&*surface.shape, surface.points.get(), &u1, side};
  }

  void clear_forces();
  // Adds a force, N, world. bend_force: the force that deforms the body, N, world. at: the motion
  // that the position follows.
  void push(const StepMotion& at, const Eigen::Vector3d& force_there,
            const Eigen::Vector3d& bend_force, const ContactTouch& touch, const PlaceRows& rows);
  void push(const Eigen::Vector3d& force_there, const Eigen::Vector3d& bend_force,
            const ContactTouch& touch, const PlaceRows& rows) {
    push(motion, force_there, bend_force, touch, rows);
  }
  void push_point(const Eigen::Vector3d& force_there, const ContactTouch& touch,
                  std::size_t point) {
    push(motion_of(point), force_there, force_there, touch, point_rows(point));
  }
  // Adds a torque alone, N m, world.
  void push_turn(const Eigen::Vector3d& torque_alone) {
    torque += motion.R0.transpose() * torque_alone;
  }

  // Adds to the Jacobian the effect of a torque alone (N m, world): fall is its fall with some
  // body's unknowns, 3 x n of the block; and the change of the torque because the body rotates.
  void add_turn_slopes(const Eigen::Ref<const Eigen::Matrix3Xd>& fall,
                       Eigen::Ref<Eigen::MatrixXd> block) const;
  void add_turn_geometry(const Eigen::Vector3d& torque_alone);
  // Derivative of theta x arm with the body's own unknowns, theta its rotation: the path of the
  // surface of a round point at that arm, 3 x n.
  Eigen::Matrix3Xd roll_slopes(const Eigen::Vector3d& arm) const;

  // Adds to the Jacobian the change of the force on a position because the position and the body
  // rotate. Needs the lever's swing.
  void add_geometry(const Eigen::Vector3d& force_there, const Eigen::Vector3d& bend_force,
                    const ContactTouch& touch, const PlaceRows& rows);
  // The same for a force on a contact point.
  void add_geometry_at_point(const Eigen::Vector3d& force_there, const ContactTouch& touch,
                             std::size_t point);
  // The same for a force at another body's point: the part that does not depend on that body's
  // unknowns.
  void add_geometry_of_other(const Eigen::Vector3d& force_there, const Eigen::Vector3d& bend_force,
                             const ContactTouch& touch, const PlaceRows& rows);

  // The residual with all rows as momenta, kg^1/2 m/s.
  double size_of_residual() const;
  // Product of the residual, as forces, with a move of the unknowns: the slope of the function that
  // the step minimizes, J, except for rotation.
  double work_along(const Eigen::Ref<const Eigen::VectorXd>& move) const;
  // The largest displacement of any point by a move of the unknowns, m.
  double way_of(const Eigen::Ref<const Eigen::VectorXd>& move) const;
  // Rounding error of the residual from a spring (N/m) at a position of the body, at the distance
  // `far` (m) from the world's origin, kg^1/2 m/s.
  double spring_rounding(const VertexRows& place, double stiffness, double far) const;
};

}  // namespace tremolo
