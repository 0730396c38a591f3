#include "tests/lab/known/spring_chain.h"

#include <Eigen/Eigenvalues>

#include "tests/lab/known/quartic_model.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {
namespace {

const Eigen::Vector4d kStiffness(3e4, 8e4, 1.5e5, 2.4e5);  // N/m

// Extensions of the four bars from the three displacements.
Eigen::Matrix<double, 4, 3> extensions() {
  Eigen::Matrix<double, 4, 3> b;
  b << 1, 0, 0,  //
      -1, 1, 0,  //
      0, -1, 1,  //
      0, 0, -1;
  return b;
}

}  // namespace

SpringChain spring_chain() {
  const Eigen::Matrix<double, 4, 3> b = extensions();
  const Eigen::Matrix3d stiffness = b.transpose() * kStiffness.asDiagonal() * b;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(stiffness);
  BasisData data = quadratic_basis(solver.eigenvalues());
  const Eigen::Matrix<double, 4, 3> reduced = b * solver.eigenvectors();
  for (Eigen::Index s = 0; s < 4; ++s) {
    add_cube(data, 0.5 * kStiffness[s], reduced.row(s).transpose());
    add_fourth_power(data, 0.125 * kStiffness[s], reduced.row(s).transpose());
  }
  return {or_fail(Model::from_data(data)), solver.eigenvectors()};
}

double spring_chain_energy(const Eigen::Vector3d& u) {
  const Eigen::Array4d d = (extensions() * u).array();
  return 0.5 * (kStiffness.array() * (d + 0.5 * d.square()).square()).sum();
}

State spring_chain_state(const SpringChain& chain, double scale) {
  const Eigen::Vector3d u(0.25, -0.15, 0.15);
  const Eigen::Vector3d v(-30.0, 60.0, 40.0);
  return {scale * chain.modes.transpose() * u, scale * chain.modes.transpose() * v};
}

}  // namespace tremolo::known
