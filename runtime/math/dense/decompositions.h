// Decompositions of dense matrices that several rooms need, none of them inside a step. Eigen's are
// compiled only here, since each costs seconds wherever it is used.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// values: n, ascending. vectors: n x n, an orthonormal column for each value.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

// a: n x n, symmetric; the lower triangle is read. By Eigen::SelfAdjointEigenSolver.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
// The values alone, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

// True if all eigenvalues of a symmetric matrix are positive, by Cholesky's factors.
bool is_positive_definite(const Eigen::MatrixXd& a);

// The columns of a (n x c, c <= n) and what is orthogonal to all of them. rank: of a, to rounding.
// complement: n x (n - c), orthonormal; empty where the rank is less than c.
struct ColumnSpace {
  Eigen::Index rank = 0;
  Eigen::MatrixXd complement;
};
ColumnSpace column_space(const Eigen::MatrixXd& a);

// The shortest x that makes a x as near b as can be: a^-1 b where a is regular.
Eigen::Matrix3d solve_shortest(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);
Eigen::Vector3d solve_shortest(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);

}  // namespace tremolo
