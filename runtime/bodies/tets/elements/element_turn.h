// The change of an element's energy with its rotation: R exp([w]) rotates the strain, S ->
// exp(-[w]) S, and to second order in w (tet_element.h has the symbols)
//   dS = -[w] S,   db = P w,   P = tr(mean) 1 - mean,
//   dW = g.w + 1/2 w.H w,
//   g  = -sum ax(S sigma) + m P^T b,
//   H  = sum (sym(S sigma) - tr(S sigma) 1)  +  m (P^T P - b b^T - sym([b] mean))  (second order)
//        + sum sym([e_i] S) : C sym([e_j] S)
// where sums over samples include their volumes.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "runtime/bodies/tets/elements/tet_element.h"
#include "runtime/math/pose.h"

namespace tremolo {

// Rotations in three dimensions: the one nearest to a matrix, small rotations, axial vectors.
//
// The nearest rotation R of A maximises tr(R^T A) over all rotations, and so minimises |A - R|_F.
// For A = U S V^T with rotations U, V and S = diag(s_1 >= s_2 >= |s_3|), s_3 with the sign of det
// A, it is U V^T: an inverted matrix is corrected along its thinnest direction. Where det A > 0 it
// is the factor of the polar decomposition, found by Newton's iteration (Higham 1986)
//   X <- (g X + X^-T / g) / 2,    g = (|X^-1|_F / |X|_F)^1/2,
// which fails for flat and inverted A; for those the singular value decomposition is used.

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

// Rotates blocks of a symmetric element matrix from the element's frame into space. out_k = factor
// R in_k R^T for all blocks of `in`; out may be in. Allocates nothing.
void turn_blocks(const Eigen::Matrix3d& rotation, double factor,
                 std::span<const Eigen::Matrix3d> in, Eigen::Matrix3d* out);

// Derivatives of the energy by the rotation.
struct TurnDerivatives {
  Eigen::Vector3d gradient;  // g
  Eigen::Matrix3d hessian;   // H
  // sum sym([e_i]S):C sym([e_j]S) + m P^T P, which is positive: K' between the rigid rotations of
  // the shape.
  Eigen::Matrix3d turned;
};
TurnDerivatives turn_derivatives(const TetElement& element, const Elasticity& elasticity,
                                 const TetShape& shape);

// H and `turned` alone, which may be stored in the shape.
struct TurnMatrices {
  Eigen::Matrix3d hessian;
  Eigen::Matrix3d turned;
};
TurnMatrices turn_matrices(const TetElement& element, const Elasticity& elasticity,
                           const TetShape& shape);

// tr(S) 1 - S.
Eigen::Matrix3d trace_minus(const Eigen::Matrix3d& s);

// Rotates the element to R exp([w]).
void turn_shape(const TetElement& element, const Elasticity& elasticity, const Eigen::Vector3d& w,
                TetShape& shape);

// Newton's method for g = 0 from the shape's R, with a line search down the energy. Sets
// `converged`.
void find_least_energy(const TetElement& element, const Elasticity& elasticity, TetShape& shape);

// A^-1 of a symmetric matrix. Eigenvalues smaller than 1e-9 of the largest in magnitude are
// replaced by that value, so that the inverse is finite.
Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& a);

}  // namespace tremolo
