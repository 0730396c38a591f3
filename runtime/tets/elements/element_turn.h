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

#include <Eigen/Core>

#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

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
