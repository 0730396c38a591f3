// Dense matrix decompositions that several stages need, by Eigen or, for large matrices, by LAPACK
// (large_decompositions.h). They are compiled only here, since each costs seconds of compile time.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// Number of rows or columns from which LAPACK is used; Eigen would take minutes.
inline constexpr Eigen::Index kLarge = 600;

// values: ascending. vectors: n x n, one column for each value. found: whether the iteration
// converged.
struct EigenPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool found = false;
};

// Solves a x = lambda x with orthonormal vectors. a: n x n, symmetric; the lower triangle is read.
EigenPairs eigenpairs(const Eigen::MatrixXd& a);

// Solves a x = lambda b x with b-orthonormal vectors. b: n x n, positive definite (not checked).
EigenPairs eigenpairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// Which vectors of a = U diag(values) V^T to compute: the first min(m, n) columns of U, or all of
// V.
enum class SingularVectors { kNone, kThinLeft, kFullRight };

// values: descending. vectors: U, V or empty.
struct SingularPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

// Returns the singular values and the requested vectors. a: m x n.
SingularPairs singular_pairs(const Eigen::MatrixXd& a, SingularVectors wanted);

// Returns R of a = Q R, n x n. a: m x n with m >= n.
Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& a);

}  // namespace tremolo
