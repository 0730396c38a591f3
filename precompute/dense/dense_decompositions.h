// Decompositions of dense matrices that several stages need. They are Eigen's, large ones LAPACK's
// (large_decompositions.h); each takes the compiler seconds, so they are compiled here once.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// From so many rows or columns on LAPACK decomposes: Eigen's take minutes there.
inline constexpr Eigen::Index kLarge = 600;

// values: ascending. vectors: n x n, one column a value. found: whether the iteration converged.
struct EigenPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool found = false;
};

// a x = lambda x, vectors orthonormal. a: n x n, symmetric; its lower triangle is read.
EigenPairs eigenpairs(const Eigen::MatrixXd& a);

// a x = lambda b x, vectors orthonormal in b. b: n x n, positive definite, which is not checked.
EigenPairs eigenpairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// What of a = U diag(values) V^T is wanted: U's first min(m, n) columns, or all of V.
enum class SingularVectors { kNone, kThinLeft, kFullRight };

// values: descending. vectors: U, V or nothing.
struct SingularPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

// a: m x n.
SingularPairs singular_pairs(const Eigen::MatrixXd& a, SingularVectors wanted);

// R of a = Q R, n x n. a: m x n with m >= n.
Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& a);

}  // namespace tremolo
