// Rigid motions of a mesh, with which momenta are restored without deformation.
#pragma once

#include <Eigen/Core>

#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

// Centre of mass, m, and inertia about it, kg m^2: sum M_IJ (x_I.x_J 1 - x_J x_I^T).
struct RigidInertia {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};
// work: 3 nodes(), overwritten.
RigidInertia rigid_inertia(const TetModel& model, const Eigen::VectorXd& x, Eigen::VectorXd& work);

// The rigid motions that the fixed control points of a mesh permit.
struct RigidFreedom {
  enum class Kind {
    kAll,         // no point is fixed
    kAboutPoint,  // rotations about `pivot`
    kAboutAxis,   // rotations about the line from `pivot` to `axis_end`
    kNone         // fixed points span a triangle
  };
  Kind kind = Kind::kAll;
  // Numbers of two fixed control points; axis_end is away from the pivot.
  std::size_t pivot = 0, axis_end = 0;
};
RigidFreedom rigid_freedom(const TetModel& model);

// rigid = the permitted rigid motion at x that is nearest to the velocities v in kinetic energy: v
// - rigid has neither momentum nor angular momentum, and its kinetic energy is that of v less that
// of rigid. For bodies with fixed points this holds for the permitted motions. work: 3 nodes(),
// overwritten. x, v, rigid and work are different vectors. Allocates nothing.
void rigid_part(const TetModel& model, const RigidFreedom& freedom, const Eigen::VectorXd& x,
                const Eigen::VectorXd& v, Eigen::VectorXd& work, Eigen::VectorXd& rigid);

// v += w x (x - centre) with w = J^-1 spin: adds `spin`, kg m^2/s, to the angular momentum.
void restore_spin(const TetModel& model, const Eigen::Vector3d& spin, const Eigen::VectorXd& x,
                  Eigen::VectorXd& v, Eigen::VectorXd& work);

// A small rigid motion whose inertia rate M removes the sum and the torque of the residual, to
// first order. False, with `motion` undefined: they are rounding already.
bool rigid_correction(const TetModel& model, const Eigen::VectorXd& x,
                      const Eigen::VectorXd& residual, double rate, Eigen::VectorXd& motion);

}  // namespace tremolo
