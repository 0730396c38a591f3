// Rotations in three dimensions: the one nearest to a matrix, small rotations, axial vectors.
//
// The nearest rotation R of A maximises tr(R^T A) over all rotations, and so minimises |A - R|_F.
// For A = U S V^T with rotations U, V and S = diag(s_1 >= s_2 >= |s_3|), s_3 with the sign of det
// A, it is U V^T: an inverted matrix is corrected along its thinnest direction. Where det A > 0 it
// is the factor of the polar decomposition, found by Newton's iteration (Higham 1986)
//   X <- (g X + X^-T / g) / 2,    g = (|X^-1|_F / |X|_F)^1/2,
// which fails for flat and inverted A; for those the singular value decomposition is used.
#pragma once

#include <Eigen/Core>

#include "runtime/frames/pose.h"

namespace tremolo {

// Always a rotation to rounding, for any A. For a matrix that is flat to rounding, or whose two
// smallest singular values cancel (s_2 + s_3 = 0), it is one of several equally near rotations; for
// zero and for values that are not finite it is the identity.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& a);

// exp([w]): the rotation by |w| radians about w.
Eigen::Matrix3d rotation_by(const Eigen::Vector3d& w);

// ax(A)_k = sum_ij eps_kij A_ij, so that tr([w] A) = w . ax(A) and ax([w]) = -2 w.
inline Eigen::Vector3d axial(const Eigen::Matrix3d& a) {
  return {a(1, 2) - a(2, 1), a(2, 0) - a(0, 2), a(0, 1) - a(1, 0)};
}

}  // namespace tremolo
