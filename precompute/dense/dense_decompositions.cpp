#include "precompute/dense/dense_decompositions.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "precompute/dense/large_decompositions.h"
#include "precompute/system/blas_threads.h"

namespace tremolo {

EigenPairs eigenpairs(const Eigen::MatrixXd& a) {
  if (a.rows() >= kLarge) return large_eigenpairs(a);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

EigenPairs eigenpairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, b);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

SingularPairs singular_pairs(const Eigen::MatrixXd& a, SingularVectors wanted) {
  const bool large = std::max(a.rows(), a.cols()) >= kLarge;
  const BlasThreads threads(large ? blas_thread_count() : 1);
  if (wanted == SingularVectors::kRight) return left_singular_pairs(a.transpose());
  SingularPairs pairs = left_singular_pairs(a);
  if (wanted == SingularVectors::kNone) pairs.vectors.resize(0, 0);
  return pairs;
}

Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

}  // namespace tremolo
