#include "precompute/reduction/many_columns.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>

#include "common/stage_log.h"
#include "common/text.h"
#include "precompute/dense/large_decompositions.h"
#include "precompute/dense/parallel_columns.h"
#include "precompute/dense/sparse_rows.h"
#include "precompute/system/blas_threads.h"

namespace tremolo {
namespace {

using Clock = std::chrono::steady_clock;

// Moves the columns order[0], order[1], ... (`count` of them) to the front, in place.
void take_to_front(const std::vector<Eigen::Index>& order, Eigen::Index count, Columns& columns) {
  std::vector<Eigen::Index> column_slot(order.size());  // slot of each column
  std::vector<Eigen::Index> in_slot(order.size());      // column in each slot
  std::iota(column_slot.begin(), column_slot.end(), 0);
  std::iota(in_slot.begin(), in_slot.end(), 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index wanted = order[i];
    const Eigen::Index from = column_slot[wanted];
    const Eigen::Index displaced = in_slot[i];
    columns.col(i).swap(columns.col(from));
    std::swap(in_slot[i], in_slot[from]);
    column_slot[wanted] = i;
    column_slot[displaced] = from;
  }
}

// Computes X <- X R^-1 by blocks of rows.
void divide(ColumnsOut x, const ColumnsRef& r, unsigned threads) {
  constexpr Eigen::Index kRows = 256;
  const BlasThreads single(1);
  parallel_columns(x.rows(), kRows, threads, [&](Eigen::Index first, Eigen::Index count) {
    divide_by_upper(r, x.middleRows(first, count));
  });
}

}  // namespace

Columns product(Mat matrix, const ColumnsRef& x, unsigned threads) {
  if (mpi_ranks() > 1) return multiply(matrix, x);
  const SparseRows rows = sparse_rows(matrix);
  Columns y(x.rows(), x.cols());
  parallel_columns(x.cols(), 4, threads, [&](Eigen::Index first, Eigen::Index count) {
    multiply(rows, x.middleCols(first, count), y.middleCols(first, count));
  });
  return y;
}

Eigen::MatrixXd gram(Mat matrix, const ColumnsRef& x, unsigned threads, const Progress& progress) {
  constexpr Eigen::Index kBlock = 32;
  constexpr double kReportInterval = 5;  // s
  Clock::time_point last_report = Clock::now();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(x.cols(), x.cols());
  for (Eigen::Index first = 0; first < x.cols(); first += kBlock) {
    const Eigen::Index count = std::min(kBlock, x.cols() - first);
    products.block(0, first, first + count, count) = transposed_product(
        x.leftCols(first + count), product(matrix, x.middleCols(first, count), threads));
    if (!progress || seconds_since(last_report) < kReportInterval) continue;
    last_report = Clock::now();
    const double share = static_cast<double>(first + count) / static_cast<double>(x.cols());
    progress(text("Gram matrix: %.0f %%", 100.0 * share * share));
  }
  sum_over_ranks(products);
  return products.selfadjointView<Eigen::Upper>();
}

Factored orthonormalise_many(Mat mass, Columns& columns, const Eigen::VectorXd& weight,
                             unsigned threads, const Progress& progress) {
  const auto report = [&progress](const std::string& what) {
    if (progress) progress(what);
  };
  const Eigen::Index n = columns.cols();
  report(text("Gram matrix of %d columns", static_cast<int>(n)));
  Eigen::MatrixXd products = gram(mass, columns, threads, progress);
  // A column may be zero: modes of disconnected parts have no common derivative.
  const Eigen::VectorXd norms =
      products.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  products = norms.cwiseInverse().asDiagonal() * products * norms.cwiseInverse().asDiagonal();
  // Resolution of a Gram matrix, squared; the error of its entries grows with their number.
  const double resolved =
      std::max(1e-12, static_cast<double>(n) * std::numeric_limits<double>::epsilon());
  report("choosing among them by a pivoted Cholesky factorisation");
  const PivotedCholesky chosen = pivoted_cholesky(std::move(products), resolved);
  Factored factored;
  factored.rank = chosen.factor.rows();
  take_to_front(chosen.order, factored.rank, columns);
  Eigen::MatrixXd first = chosen.factor.leftCols(factored.rank);
  for (Eigen::Index i = 0; i < factored.rank; ++i) first.col(i) *= norms[chosen.order[i]];
  divide(columns.leftCols(factored.rank), first, threads);

  report(text("Gram matrix of the %d that hold the others", static_cast<int>(factored.rank)));
  const Eigen::MatrixXd second =
      cholesky_factor(gram(mass, columns.leftCols(factored.rank), threads, progress));
  factored.q = Eigen::MatrixXd::Identity(factored.rank, factored.rank);
  divide_by_upper(second, factored.q);
  factored.t.resize(factored.rank, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index column = chosen.order[i];
    factored.t.col(column) = (norms[column] * weight[column]) * chosen.factor.col(i);
  }
  multiply_by_upper(second, factored.t);
  return factored;
}

ManyColumnsCost cost_of_many_columns(Eigen::Index rows, Eigen::Index columns, unsigned threads) {
  const BlasThreads all(static_cast<int>(threads));
  constexpr Eigen::Index kSize = 512;
  const Eigen::MatrixXd factor = Eigen::MatrixXd::Constant(kSize, kSize, 1e-3);
  Eigen::MatrixXd result(kSize, kSize);
  double shortest = 1e30;
  for (int run = 0; run < 3; ++run) {
    const Clock::time_point start = Clock::now();
    add_product(1.0, factor, factor, 0.0, result);
    shortest = std::min(shortest, seconds_since(start));
  }
  const double speed = 2.0 * kSize * kSize * kSize / shortest;
  const auto local = static_cast<double>(rows), n = static_cast<double>(columns);
  const double rank = std::min(n, over_ranks(local, MPI_SUM));
  // Half of the reduction to singular values is bound by memory bandwidth; measured.
  constexpr double kSingular = 40;
  const double flops = 2.0 * local * n * n + 3.0 * local * rank * rank + 4.0 * rank * rank * n +
                       kSingular * rank * rank * rank;
  constexpr double kNumber = 8;
  return {flops / speed, kNumber * (3.0 * n * n + 7.0 * rank * rank)};
}

}  // namespace tremolo
