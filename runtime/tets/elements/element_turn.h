// How an element's energy changes with its rotation: R exp([w]) turns what the element sees,
// S -> exp(-[w]) S, and to second order in w (tet_element.h has the letters)
//   dS = -[w] S,   db = P w,   P = tr(mean) 1 - mean,
//   dW = g.w + 1/2 w.H w,
//   g  = -sum ax(S sigma) + m P^T b,
//   H  = sum (sym(S sigma) - tr(S sigma) 1)  +  m (P^T P - b b^T - sym([b] mean))  (second order)
//        + sum sym([e_i] S) : C sym([e_j] S)
// where sums over samples carry their volumes.
#pragma once

#include <array>

#include <Eigen/Core>

#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

// gradient: g. hessian: H. turned: sum sym([e_i]S):C sym([e_j]S) + m P^T P, which is positive: K'
// between the rigid turns of the shape.
struct TurnDerivatives {
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
  Eigen::Matrix3d turned;
};
TurnDerivatives turn_derivatives(const TetElement& element, const Elasticity& elasticity,
                                 const TetShape& shape);

// H and `turned` alone, which the shape may have already.
struct TurnMatrices {
  Eigen::Matrix3d hessian;
  Eigen::Matrix3d turned;
};
TurnMatrices turn_matrices(const TetElement& element, const Elasticity& elasticity,
                           const TetShape& shape);

// tr(S) 1 - S.
Eigen::Matrix3d trace_minus(const Eigen::Matrix3d& s);

// Turns the element to R exp([w]).
void turn_shape(const TetElement& element, const Elasticity& elasticity, const Eigen::Vector3d& w,
                TetShape& shape);

// Newton's method for g = 0 from the R that the shape has, with a line search down the energy.
// Sets `converged`.
void find_least_energy(const TetElement& element, const Elasticity& elasticity, TetShape& shape);

// A^-1 of a symmetric matrix; eigenvalues smaller than 1e-9 of the largest in magnitude are taken
// for that, so that it is finite.
Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& a);

}  // namespace tremolo
