// Rigid motions of a mesh: what restores momenta without bending anything.
#pragma once

#include <Eigen/Core>

#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

// Centre of mass, m, and inertia about it, kg m^2: sum M_IJ (x_I.x_J 1 - x_J x_I^T).
struct RigidInertia {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};
// work: 3 nodes(), overwritten.
RigidInertia rigid_inertia(const TetModel& model, const Eigen::VectorXd& x, Eigen::VectorXd& work);

// v += w x (x - centre) with w = J^-1 spin: adds `spin`, kg m^2/s, to the angular momentum.
void restore_spin(const TetModel& model, const Eigen::Vector3d& spin, const Eigen::VectorXd& x,
                  Eigen::VectorXd& v, Eigen::VectorXd& work);

// A small rigid motion whose inertia rate M takes away the sum and the torque of the residual, to
// first order. False where they are rounding already; `motion` is then undefined.
bool rigid_correction(const TetModel& model, const Eigen::VectorXd& x,
                      const Eigen::VectorXd& residual, double rate, Eigen::VectorXd& motion);

}  // namespace tremolo
