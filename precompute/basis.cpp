#include "precompute/basis.h"

#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "common/packed_index.h"
#include "precompute/blas_threads.h"
#include "precompute/failure.h"
#include "precompute/parallel_columns.h"
#include "precompute/sparse_rows.h"

namespace tremolo {
namespace {

// How the columns enter a motion u = sum Psi_i p_i + 1/2 sum Phi_ij p_i p_j whose amplitudes are
// p_i = a w2_1/w2_i, divided by a.
Eigen::VectorXd weights(const Eigen::VectorXd& w2, double amplitude, Eigen::Index columns) {
  const Eigen::Index k = w2.size();
  Eigen::VectorXd weight(columns);
  weight.head(k) = w2[0] * w2.cwiseInverse();
  if (columns == k) return weight;
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i)
      weight[k + static_cast<Eigen::Index>(pair_index(i, j))] =
          0.5 * amplitude * w2[0] * w2[0] / (w2[i] * w2[j]);
  return weight;
}

// A X for some columns.
Columns product(Mat matrix, const ColumnsRef& x, unsigned threads) {
  if (mpi_ranks() > 1) return multiply(matrix, x);
  const SparseRows rows = sparse_rows(matrix);
  Columns y(x.rows(), x.cols());
  parallel_columns(x.cols(), 4, threads, [&](Eigen::Index first, Eigen::Index count) {
    multiply(rows, x.middleCols(first, count), y.middleCols(first, count));
  });
  return y;
}

// X^T A X by blocks of columns, the upper triangle mirrored.
Eigen::MatrixXd gram(Mat matrix, const ColumnsRef& x, unsigned threads) {
  constexpr Eigen::Index kBlock = 32;
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(x.cols(), x.cols());
  for (Eigen::Index first = 0; first < x.cols(); first += kBlock) {
    const Eigen::Index count = std::min(kBlock, x.cols() - first);
    products.block(0, first, first + count, count) = transposed_product(
        x.leftCols(first + count), product(matrix, x.middleCols(first, count), threads));
  }
  sum_over_ranks(products);
  return products.selfadjointView<Eigen::Upper>();
}

// X <- X P, by blocks of rows: P's columns are no more than X's, the rest of X is left as it is.
void transform(ColumnsOut x, const Eigen::MatrixXd& p, unsigned threads) {
  constexpr Eigen::Index kRows = 1024;
  const BlasThreads single(1);
  parallel_columns(x.rows(), kRows, threads, [&](Eigen::Index first, Eigen::Index count) {
    const Columns block = x.middleRows(first, count);
    add_product(1.0, block, p, 0.0, x.block(first, 0, count, p.cols()));
  });
}

// W = Q T with Q^T M Q = I, W = columns * weight. A Gram matrix squares the condition, so columns
// are first scaled to unit M-norm and compressed to the directions it can resolve; a second pass on
// the compressed columns, now well conditioned, makes Q orthonormal to rounding. What comes back is
// Q = columns * q, the first `rank` columns having been changed in place.
struct Factored {
  Eigen::Index rank;
  Eigen::MatrixXd q;
  Eigen::MatrixXd t;
};
Factored orthonormalise(Mat mass, Columns& columns, const Eigen::VectorXd& weight,
                        unsigned threads) {
  const Eigen::MatrixXd first = gram(mass, columns, threads);
  // A column may be zero: modes of parts that do not touch have no common derivative.
  const Eigen::VectorXd norms =
      first.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const Eigen::MatrixXd scaled =
      norms.cwiseInverse().asDiagonal() * first * norms.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  constexpr double kResolved = 1e-12;  // of the largest: what a Gram matrix holds above rounding
  const double largest = eigen.eigenvalues().maxCoeff();
  Factored factored;
  factored.rank = (eigen.eigenvalues().array() > kResolved * largest).count();
  const Eigen::VectorXd root = eigen.eigenvalues().tail(factored.rank).cwiseSqrt();
  const Eigen::MatrixXd directions = eigen.eigenvectors().rightCols(factored.rank);
  transform(columns,
            norms.cwiseInverse().asDiagonal() * directions * root.cwiseInverse().asDiagonal(),
            threads);
  const Eigen::LLT<Eigen::MatrixXd> second(gram(mass, columns.leftCols(factored.rank), threads));
  factored.q = second.matrixU().solve(Eigen::MatrixXd::Identity(factored.rank, factored.rank));
  factored.t = second.matrixU() * (root.asDiagonal() * directions.transpose() *
                                   norms.cwiseProduct(weight).asDiagonal());
  return factored;
}

}  // namespace

Basis make_basis(const Matrices& matrices, Columns columns, const Eigen::VectorXd& w2,
                 double amplitude, int r, unsigned threads) {
  const Mat mass = matrices.mass.get();
  const Factored factored =
      orthonormalise(mass, columns, weights(w2, amplitude, columns.cols()), threads);
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(factored.t, Eigen::ComputeThinU);
  const Eigen::VectorXd& sigma = svd.singularValues();
  constexpr double kRank = 1e-13;  // of the largest singular value: below is rounding
  const auto rank = (sigma.array() > kRank * sigma[0]).count();
  if (r < 1 || r > rank)
    throw Failure(
        content_error(std::to_string(r) + " coordinates asked for; " + std::to_string(w2.size()) +
                      " linear modes with their derivatives span " + std::to_string(rank)));
  Basis basis;
  basis.singular_values.assign(sigma.data(), sigma.data() + sigma.size());
  Columns reduced(columns.rows(), r);
  add_product(1.0, columns.leftCols(factored.rank), factored.q * svd.matrixU().leftCols(r), 0.0,
              reduced);
  columns.resize(0, 0);

  // The generalised form takes up what rounding has left of orthonormality.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> rotation(
      gram(matrices.stiffness.get(), reduced, threads), gram(mass, reduced, threads));
  basis.lambda = rotation.eigenvalues();
  transform(reduced, rotation.eigenvectors(), threads);
  basis.vectors = std::move(reduced);

  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  basis.orthonormality_error =
      (gram(mass, basis.vectors, threads) - identity).cwiseAbs().maxCoeff();
  Eigen::MatrixXd stiffness = gram(matrices.stiffness.get(), basis.vectors, threads);
  stiffness.diagonal() -= basis.lambda;
  basis.diagonality_error = stiffness.cwiseAbs().maxCoeff() / basis.lambda.maxCoeff();
  return basis;
}

}  // namespace tremolo
