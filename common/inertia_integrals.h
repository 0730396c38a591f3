// Integrals of the mass over the rest shape X and the basis fields phi_i = U_i, by which a body in
// a moving frame is coupled to its frame (docs/theory.md, section "A body in a world").
#pragma once

#include <Eigen/Core>

namespace tremolo {

// From the mass matrix with the rows of fixed vertices; X is measured from the mesh's origin.
// A "3 k + l" row holds the entry (k, l) of a 3 x 3 matrix.
struct InertiaIntegrals {
  double mass = 0;                // int rho, kg
  Eigen::Vector3d first_moment;   // int rho X, kg m
  Eigen::Matrix3d second_moment;  // int rho X X^T, kg m^2
  // 12 x r: rows 0 to 2 are s_i = int rho phi_i, kg^1/2; the next nine are
  // A_i = int rho X phi_i^T, kg^1/2 m.
  Eigen::MatrixXd linear;
  // 9 x pair_count(r), column pair_index(i, j) with i <= j: B_ij = int rho phi_i phi_j^T.
  // B_ji is its transpose, and tr B_ij is 1 for i = j, else 0.
  Eigen::MatrixXd B;
};

}  // namespace tremolo
