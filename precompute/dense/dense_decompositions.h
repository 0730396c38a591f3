// Dense matrix decompositions that several stages need. Singular values come from LAPACK, the
// others from Eigen or, for large matrices, from LAPACK (large_decompositions.h). Eigen's are
// compiled only here, since each costs seconds of compile time.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// Number of rows or columns from which a matrix is large: Eigen would take minutes, and LAPACK
// takes all of BLAS's threads. Below, the results do not depend on the number of threads.
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

// Vectors of a = U diag(values) V^T that are to be returned: the first min(m, n) columns of U or of
// V.
enum class SingularVectors { kNone, kLeft, kRight };

// values: descending. vectors: U, V or empty.
struct SingularPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

// Returns the singular values and the requested vectors, by divide and conquer: values are accurate
// to rounding of the largest one, as none is squared. a: m x n. Throws Failure (kSolver) if the
// iteration does not converge.
SingularPairs singular_pairs(const Eigen::MatrixXd& a, SingularVectors wanted);

// Returns R of a = Q R, n x n. a: m x n with m >= n.
Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& a);

}  // namespace tremolo
