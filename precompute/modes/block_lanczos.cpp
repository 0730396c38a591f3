#include "precompute/modes/block_lanczos.h"

#include <random>

#include "precompute/dense/dense_decompositions.h"
#include "precompute/dense/parallel_columns.h"
#include "precompute/dense/sparse_rows.h"
#include "precompute/system/blas_threads.h"

namespace tremolo {
namespace {

constexpr Eigen::Index kBlock = kLanczosBlock;

// Returns X^T Y, bitwise the same on all ranks.
Eigen::MatrixXd products_of(const ColumnsRef& x, const ColumnsRef& y) {
  Eigen::MatrixXd products = transposed_product(x, y);
  sum_over_ranks(products);
  return products;
}

// Returns M X; with one process on the pencil's threads, else on all ranks.
Columns mass_times(const Pencil& pencil, const ColumnsRef& x) {
  if (mpi_ranks() > 1) return multiply(pencil.mass(), Columns(x));
  const SparseRows mass = sparse_rows(pencil.mass());
  Columns product(x.rows(), x.cols());
  parallel_columns(x.cols(), 4, pencil.threads, [&](Eigen::Index first, Eigen::Index count) {
    multiply(mass, x.middleCols(first, count), product.middleCols(first, count));
  });
  return product;
}

Columns start_block(Eigen::Index rows, Eigen::Index columns) {
  // The raw output of the engine is the same on every platform.
  std::mt19937 engine(20110101u + static_cast<unsigned>(mpi_rank()));
  Columns block(rows, columns);
  for (double& entry : block.reshaped()) entry = static_cast<double>(engine()) / 4294967296.0 - 0.5;
  return block;
}

// Removes the components of w along the columns of v (M-orthonormal); returns them, v^T M w.
Eigen::MatrixXd project_out(const Pencil& pencil, const ColumnsRef& v, const ColumnsOut& w) {
  if (v.cols() == 0) return Eigen::MatrixXd(0, w.cols());
  Eigen::MatrixXd along = products_of(v, mass_times(pencil, w));
  add_product(-1.0, v, along, 1.0, w);
  return along;
}

// Factorises W = Q B with Q^T M Q = 1, in place. The first `rank` columns of w become the columns
// of Q; dropped are directions that the Gram matrix cannot distinguish from rounding of the others,
// and those that are rounding relative to `scale`. |B s| is the M-norm of W s, dropped directions
// included.
struct Orthonormalised {
  Eigen::Index rank = 0;
  Eigen::MatrixXd b;
};
Orthonormalised orthonormalise(const Pencil& pencil, ColumnsOut w, double scale) {
  // Every direction was dropped before.
  if (w.cols() == 0) return {0, Eigen::MatrixXd(0, 0)};
  const Eigen::MatrixXd gram = products_of(w, mass_times(pencil, w));
  const EigenPairs eigen = eigenpairs(0.5 * (gram + gram.transpose()));
  constexpr double kRounding = 1e-14;
  const double largest = eigen.values.maxCoeff();
  const double least = std::max(kRounding * largest, std::pow(kRounding * scale, 2));
  Orthonormalised result;
  result.rank = (eigen.values.array() > least).count();
  const Eigen::VectorXd root = eigen.values.cwiseMax(0.0).cwiseSqrt();
  const Columns old = w;
  add_product(
      1.0, old,
      eigen.vectors.rightCols(result.rank) * root.tail(result.rank).cwiseInverse().asDiagonal(),
      0.0, w.leftCols(result.rank));
  result.b = root.asDiagonal() * eigen.vectors.transpose();
  return result;
}

}  // namespace

void apply_inverse(const Pencil& pencil, const ShiftedSolver& solver, ColumnsOut x) {
  Columns load = mass_times(pencil, x);
  if (solver.threads_may_share()) {
    const BlasThreads single(1);
    parallel_columns(x.cols(), kBlock, pencil.threads, [&](Eigen::Index first, Eigen::Index count) {
      solver.solve(load.middleCols(first, count), x.middleCols(first, count));
    });
  } else {
    solver.solve(load, x);
  }
  project_out(pencil, pencil.rigid, x);
}

LanczosPairs block_lanczos(const Pencil& pencil, const ShiftedSolver& solver, int wanted,
                           double tolerance) {
  const Eigen::Index rows = pencil.rows();
  // Many similar parts have as many nearly equal frequencies, which only a large basis separates.
  constexpr Eigen::Index kMostExtra = 1500;
  const Eigen::Index extra_for_parts =
      pencil.rigid.cols() > 6 ? std::min(kMostExtra, 2 * pencil.rigid.cols()) : 0;
  const Eigen::Index usual = 8 * Eigen::Index{wanted} + 20 * kBlock;
  const Eigen::Index most = std::min<Eigen::Index>(pencil.all_rows(), usual + extra_for_parts);
  LanczosPairs pairs;
  Columns v(rows, most);
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(most, most);  // V^T M A V
  Eigen::Index size = std::min(kBlock, most), first = 0;
  double largest = 0;
  v.leftCols(size) = start_block(rows, size);
  project_out(pencil, pencil.rigid, v.leftCols(size));
  for (int pass = 0; pass < 2; ++pass) size = orthonormalise(pencil, v.leftCols(size), 0.0).rank;
  while (size > first) {
    const Eigen::Index width = size - first;
    Columns w = v.middleCols(first, width);
    apply_inverse(pencil, solver, w);
    pairs.solves += static_cast<int>(width);
    const Eigen::MatrixXd along = project_out(pencil, v.leftCols(size), w);
    t.block(0, first, size, width) = along;
    t.block(first, 0, width, size) = along.transpose();

    // In a large basis a convergence test costs more than another step.
    constexpr Eigen::Index kTestInterval = 8 * kBlock;
    const bool test_convergence =
        size <= usual || size % kTestInterval < kBlock || size + kBlock > most;
    EigenPairs ritz;
    if (test_convergence) {
      ritz = eigenpairs(t.topLeftCorner(size, size));
      largest = std::max(largest, ritz.values.cwiseAbs().maxCoeff());
    }
    const auto [next, coupling] = orthonormalise(pencil, w, largest);
    if (test_convergence && size >= wanted) {
      const Eigen::MatrixXd chosen = ritz.vectors.rightCols(wanted).rowwise().reverse();
      pairs.values = ritz.values.tail(wanted).reverse();
      const Eigen::VectorXd residuals =
          (coupling * chosen.middleRows(first, width)).colwise().norm();
      if ((residuals.array() <= tolerance * pairs.values.array()).all()) {
        pairs.converged = true;
        pairs.vectors.resize(rows, wanted);
        add_product(1.0, v.leftCols(size), chosen, 0.0, pairs.vectors);
        return pairs;
      }
    }
    if (size + next > most) return pairs;
    // A second orthogonalisation is needed, since normalising short columns amplifies the rounding
    // left along the basis.
    project_out(pencil, pencil.rigid, w.leftCols(next));
    project_out(pencil, v.leftCols(size), w.leftCols(next));
    const Eigen::Index kept = orthonormalise(pencil, w.leftCols(next), 0.0).rank;
    v.middleCols(size, kept) = w.leftCols(kept);
    first = size;
    size += kept;
  }
  pairs.exhausted = true;
  return pairs;
}

}  // namespace tremolo
