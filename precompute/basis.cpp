#include "precompute/basis.h"

#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "common/packed_index.h"
#include "precompute/failure.h"

namespace tremolo {
namespace {

// The columns as they enter a motion u = sum Psi_i p_i + 1/2 sum Phi_ij p_i p_j whose amplitudes
// are p_i = a w2_1/w2_i, divided by a.
Columns weighted_columns(const Columns& modes, const Eigen::VectorXd& w2,
                         const Columns& derivatives, double amplitude) {
  const Eigen::Index k = modes.cols();
  Columns columns(modes.rows(), k + derivatives.cols());
  for (Eigen::Index i = 0; i < k; ++i) columns.col(i) = modes.col(i) * (w2[0] / w2[i]);
  if (derivatives.cols() == 0) return columns;
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const auto pair = static_cast<Eigen::Index>(pair_index(i, j));
      columns.col(k + pair) =
          derivatives.col(pair) * (0.5 * amplitude * w2[0] * w2[0] / (w2[i] * w2[j]));
    }
  return columns;
}

Eigen::MatrixXd gram(Mat matrix, const Columns& x) {
  const Eigen::MatrixXd products = inner_products(x, multiply(matrix, x));
  return 0.5 * (products + products.transpose());
}

// W = Q T with Q^T M Q = I. A Gram matrix squares the condition, so columns are first scaled to
// unit M-norm and compressed to the directions it can resolve; a second pass on the compressed
// columns, now well conditioned, makes Q orthonormal to rounding.
struct Factored {
  Columns q;
  Eigen::MatrixXd t;
};
Factored orthonormalise(Mat mass, const Columns& columns) {
  const Eigen::MatrixXd first = gram(mass, columns);
  // A column may be zero: modes of parts that do not touch have no common derivative.
  const Eigen::VectorXd norms =
      first.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const Eigen::MatrixXd scaled =
      norms.cwiseInverse().asDiagonal() * first * norms.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  constexpr double kResolved = 1e-12;  // of the largest: what a Gram matrix holds above rounding
  const double largest = eigen.eigenvalues().maxCoeff();
  const Eigen::Index rank = (eigen.eigenvalues().array() > kResolved * largest).count();
  const Eigen::VectorXd root = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const Eigen::MatrixXd directions = eigen.eigenvectors().rightCols(rank);
  Factored factored;
  factored.q =
      columns * (norms.cwiseInverse().asDiagonal() * directions * root.cwiseInverse().asDiagonal());
  factored.t = root.asDiagonal() * directions.transpose() * norms.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> second(gram(mass, factored.q));
  factored.q = second.matrixU().solve<Eigen::OnTheRight>(factored.q).eval();
  factored.t = second.matrixU() * factored.t;
  return factored;
}

}  // namespace

Basis make_basis(const Matrices& matrices, const Columns& modes, const Eigen::VectorXd& w2,
                 const Columns& derivatives, double amplitude, int r) {
  const Mat mass = matrices.mass.get();
  const Factored factored =
      orthonormalise(mass, weighted_columns(modes, w2, derivatives, amplitude));
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::ColPivHouseholderQRPreconditioner> svd(
      factored.t, Eigen::ComputeThinU);
  const Eigen::VectorXd& sigma = svd.singularValues();
  constexpr double kRank = 1e-13;  // of the largest singular value: below is rounding
  const auto rank = (sigma.array() > kRank * sigma[0]).count();
  if (r < 1 || r > rank)
    throw Failure(content_error(
        std::to_string(r) + " coordinates asked for; " + std::to_string(modes.cols()) +
        " linear modes with their derivatives span " + std::to_string(rank)));
  Basis basis;
  basis.singular_values.assign(sigma.data(), sigma.data() + sigma.size());
  const Columns reduced = factored.q * svd.matrixU().leftCols(r);

  // The generalised form takes up what rounding has left of orthonormality.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> rotation(
      gram(matrices.stiffness.get(), reduced), gram(mass, reduced));
  basis.lambda = rotation.eigenvalues();
  basis.vectors = reduced * rotation.eigenvectors();

  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  basis.orthonormality_error = (gram(mass, basis.vectors) - identity).cwiseAbs().maxCoeff();
  Eigen::MatrixXd stiffness = gram(matrices.stiffness.get(), basis.vectors);
  stiffness.diagonal() -= basis.lambda;
  basis.diagonality_error = stiffness.cwiseAbs().maxCoeff() / basis.lambda.maxCoeff();
  return basis;
}

}  // namespace tremolo
