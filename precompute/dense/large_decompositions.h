// Decompositions of dense matrices with thousands of rows, by LAPACK on the threads that BLAS has.
#pragma once

#include <vector>

#include "precompute/dense/blas.h"
#include "precompute/dense/dense_decompositions.h"

namespace tremolo {

// As eigenpairs(a).
EigenPairs large_eigenpairs(const Eigen::MatrixXd& a);

// As singular_pairs(a, kThinLeft), by divide and conquer: values are off by rounding of the largest
// one, none is squared. A wide matrix is first made square. Throws Failure (kSolver) when it does
// not converge.
SingularPairs large_left_singular_pairs(const Eigen::MatrixXd& a);

// R^T R = P^T A P but for a remainder whose diagonal is at most `tolerance`.
// factor: rank x n, upper trapezoidal. order: column i of A P is column order[i] of A.
struct PivotedCholesky {
  Eigen::MatrixXd factor;
  std::vector<Eigen::Index> order;
};

// a: n x n, symmetric, positive semidefinite to rounding; taken, its memory is worked in.
PivotedCholesky pivoted_cholesky(Eigen::MatrixXd a, double tolerance);

// R of R^T R = A, upper triangular. a: n x n, symmetric. Throws Failure (kSolver) when it is not
// positive definite.
Eigen::MatrixXd cholesky_factor(Eigen::MatrixXd a);

// B <- B R^-1. r: n x n, upper triangular; b: m x n.
void divide_by_upper(const ColumnsRef& r, ColumnsOut b);

// B <- R B. r: n x n, upper triangular; b: n x m.
void multiply_by_upper(const ColumnsRef& r, ColumnsOut b);

}  // namespace tremolo
