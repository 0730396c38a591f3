// Decompositions of dense matrices by LAPACK with BLAS's threads.
#pragma once

#include <vector>

#include "precompute/dense/blas.h"
#include "precompute/dense/dense_decompositions.h"

namespace tremolo {

// As eigenpairs(a).
EigenPairs large_eigenpairs(const Eigen::MatrixXd& a);

// Does what singular_pairs(a, kLeft) does. A wide matrix is first reduced to a square one.
SingularPairs left_singular_pairs(const Eigen::MatrixXd& a);

// R^T R = P^T A P up to a remainder whose diagonal is at most `tolerance`. factor: R, rank x n,
// upper trapezoidal. order: column i of A P is column order[i] of A.
struct PivotedCholesky {
  Eigen::MatrixXd factor;
  std::vector<Eigen::Index> order;
};

// a: n x n, symmetric, positive semidefinite to rounding; its memory is reused.
PivotedCholesky pivoted_cholesky(Eigen::MatrixXd a, double tolerance);

// Returns the upper triangular R of R^T R = A. a: n x n, symmetric. Throws Failure (kSolver) if it
// is not positive definite.
Eigen::MatrixXd cholesky_factor(Eigen::MatrixXd a);

// Computes B <- B R^-1. r: n x n, upper triangular; b: m x n.
void divide_by_upper(const ColumnsRef& r, ColumnsOut b);

// Computes B <- R B. r: n x n, upper triangular; b: n x m.
void multiply_by_upper(const ColumnsRef& r, ColumnsOut b);

}  // namespace tremolo
