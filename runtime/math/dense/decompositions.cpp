#include "runtime/math/dense/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace tremolo {

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

bool is_positive_definite(const Eigen::MatrixXd& a) {
  return Eigen::LLT<Eigen::MatrixXd>(a).info() == Eigen::Success;
}

ColumnSpace column_space(const Eigen::MatrixXd& a) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(a);
  ColumnSpace space;
  space.rank = factor.rank();
  if (space.rank < a.cols()) return space;
  const Eigen::MatrixXd q = factor.householderQ();
  space.complement = q.rightCols(q.cols() - a.cols());
  return space;
}

Eigen::Matrix3d solve_shortest(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  // Jacobi's method: seconds less to compile for three rows than Householder's.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& values = svd.singularValues();  // descending
  constexpr double kRounding = 3.0 * 2.3e-16;
  Eigen::Matrix3d x = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3 && values[i] > kRounding * values[0]; ++i)
    x += svd.matrixV().col(i) * ((svd.matrixU().col(i).transpose() * b) / values[i]);
  return x;
}

Eigen::Vector3d solve_shortest(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
  all.col(0) = b;
  return solve_shortest(a, all).col(0);
}

}  // namespace tremolo
