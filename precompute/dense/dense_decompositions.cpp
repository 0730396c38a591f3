#include "precompute/dense/dense_decompositions.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "precompute/dense/large_decompositions.h"

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
  if (std::max(a.rows(), a.cols()) >= kLarge && wanted == SingularVectors::kThinLeft)
    return large_left_singular_pairs(a);
  unsigned options = 0;
  if (wanted == SingularVectors::kThinLeft) options = Eigen::ComputeThinU;
  if (wanted == SingularVectors::kFullRight) options = Eigen::ComputeFullV;
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(a, options);
  SingularPairs pairs{svd.singularValues(), {}};
  if (wanted == SingularVectors::kThinLeft) pairs.vectors = svd.matrixU();
  if (wanted == SingularVectors::kFullRight) pairs.vectors = svd.matrixV();
  return pairs;
}

Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

}  // namespace tremolo
