// Smooth displacements of a whole body: the ten polynomials up to degree two in the position at
// rest, each along x, y and z. Conjugate gradients preconditioned by the diagonal's blocks find
// displacements last that are smooth over many elements, that is rotations and bending of the body.
// These thirty modes are therefore solved for at once,
//   P = D^-1 + Z A_c^-1 Z^T,
// and found first (a coarse space added to Jacobi's method; Nicolaides 1987). A_c need only be near
// Z^T A Z: it is the body's stiffness at rest, rotated by the body's mean rotation, its mass, and
// its contacts. P is positive for any A_c > 0, and the solution does not depend on it.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

inline constexpr int kSmoothFields = 10;
inline constexpr int kSmoothModes = 3 * kSmoothFields;  // number 3 k + i: field k along axis i

using SmoothFields = std::array<float, kSmoothFields>;  // their values at one control point
using SmoothMatrix = Eigen::Matrix<double, kSmoothModes, kSmoothModes>;

// The space of these modes.
struct SmoothSpace {
  // For each control point, polar forms on edges; zero where it is fixed.
  std::vector<SmoothFields> at;
  SmoothMatrix stiffness;  // Z^T K Z, N/m, at rest and of degree two everywhere
  // Z^T M Z, kg, the same along each axis.
  Eigen::Matrix<double, kSmoothFields, kSmoothFields> mass;
};
SmoothSpace smooth_space(const TetModel& model);

// A_c of a body without contacts: mass times M and stiffness times K, the latter rotated.
SmoothMatrix smooth_matrix(const SmoothSpace& space, const Eigen::Matrix3d& turn, double mass,
                           double stiffness);

}  // namespace tremolo
