// Smooth displacements of a whole body: the ten polynomials up to degree two in the place at rest,
// each along x, y and z. What conjugate gradients preconditioned by the diagonal's blocks find last
// is what is smooth over many elements, turns and bends of the body; with these thirty modes
// solved for at once,
//   P = D^-1 + Z A_c^-1 Z^T,
// they are found first (a coarse space beside Jacobi's method; Nicolaides 1987). A_c need only be
// near Z^T A Z: it is the body's stiffness at rest, turned by the body's mean rotation, its mass,
// and its touches as they are. P is positive whatever A_c > 0 is, and what is solved does not
// depend on it.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

inline constexpr int kSmoothFields = 10;
inline constexpr int kSmoothModes = 3 * kSmoothFields;  // number 3 k + i: field k along axis i

using SmoothFields = std::array<float, kSmoothFields>;  // their values at one control point
using SmoothMatrix = Eigen::Matrix<double, kSmoothModes, kSmoothModes>;

// at: of each control point, polar forms on edges; zero where it is held. stiffness: Z^T K Z, N/m,
// at rest and of degree two everywhere. mass: Z^T M Z, kg, the same along each axis.
struct SmoothSpace {
  std::vector<SmoothFields> at;
  SmoothMatrix stiffness;
  Eigen::Matrix<double, kSmoothFields, kSmoothFields> mass;
};
SmoothSpace smooth_space(const TetModel& model);

// A_c of a body without touches: mass times M and stiffness times K, the latter turned.
SmoothMatrix smooth_matrix(const SmoothSpace& space, const Eigen::Matrix3d& turn, double mass,
                           double stiffness);

}  // namespace tremolo
