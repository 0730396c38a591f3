// The inertia of a deforming body about a point of its frame (docs/theory.md, section "A body in a
// world"). With x = X + U q and v = q',
//
//     P(q) = int rho x x^T = P0 + sum_i q_i (A_i + A_i^T) + sum_ij q_i q_j sym(B_ij)
//     J(q) = tr P I - P                          inertia, kg m^2
//     C(q) = [sum_i q_i c_ij]_j,                 3 x r, so that int rho x * x' = (a_j + C(q)_j) v_j
//     a_i  = int rho X x phi_i,  c_ij = int rho phi_i x phi_j = -c_ji
#pragma once

#include <array>

#include <Eigen/Core>

#include "common/energy.h"

namespace tremolo {

// The six entries of a symmetric 3 x 3 matrix: xx yy zz xy yz zx.
inline constexpr std::array<std::array<int, 2>, 6> kSymmetricEntries = {
    {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};

// All inertia about one point of the frame. A model makes it once; bodies share it.
struct FrameInertia {
  // about: the point, in the mesh's coordinates, m.
  FrameInertia(const InertiaIntegrals& integrals, const Eigen::Vector3d& about);

  Eigen::Index modes() const { return s.cols(); }

  double mass;
  Eigen::Vector3d centre;
  Eigen::Vector3d first_moment;  // about the centre, kg m
  Eigen::Matrix3d P0;            // kg m^2
  Eigen::Matrix3Xd s;            // 3 x r: int rho phi_i, kg^1/2
  Eigen::Matrix3Xd a;            // 3 x r, kg^1/2 m
  Eigen::MatrixXd P_linear;      // r x 6: entries of A_i + A_i^T
  // Rows m r + i: (c_m)_ij, skew for each of the three components. Rows 3 r + e r + i after them:
  // the entry e of sym(B_ij), symmetric for each of the six; zeros below. One product with q gives
  // all (runtime/math/dense/small_matrices.h).
  Eigen::MatrixXd pairs;  // tall_rows(9r) x r
};

// P and C at one q, with the values that their derivatives need. Nothing is allocated after
// construction.
struct InertiaAt {
  explicit InertiaAt(Eigen::Index modes);

  void compute(const FrameInertia& inertia, const Eigen::VectorXd& q);

  // sum_j of C_j v_j.
  Eigen::Vector3d couple(const Eigen::VectorXd& v) const { return C * v; }

  Eigen::VectorXd products;  // tall_rows(9r): pairs q
  Eigen::Matrix3Xd C;        // 3 x r
  Eigen::Matrix3d J;         // about the centre, kg m^2
};

}  // namespace tremolo
