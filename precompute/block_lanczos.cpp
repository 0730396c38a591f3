#include "precompute/block_lanczos.h"

#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "precompute/blas_threads.h"
#include "precompute/parallel_columns.h"

namespace tremolo {
namespace {

constexpr Eigen::Index kBlock = kLanczosBlock;

Columns times_mass(const Pencil& pencil, const ColumnsRef& x, unsigned threads) {
  Columns product(x.rows(), x.cols());
  parallel_columns(x.cols(), 4, threads, [&](Eigen::Index first, Eigen::Index count) {
    multiply(pencil.mass, x.middleCols(first, count), product.middleCols(first, count));
  });
  return product;
}

Columns start_block(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 engine(20110101);  // its raw numbers are the same everywhere
  Columns block(rows, columns);
  for (double& entry : block.reshaped()) entry = static_cast<double>(engine()) / 4294967296.0 - 0.5;
  return block;
}

// Takes the part along the columns of v (M-orthonormal) out of w; returns what it was, v^T M w.
Eigen::MatrixXd project_out(const Pencil& pencil, const ColumnsRef& v, ColumnsOut w,
                            unsigned threads) {
  if (v.cols() == 0) return Eigen::MatrixXd(0, w.cols());
  const Eigen::MatrixXd along = transposed_product(v, times_mass(pencil, w, threads));
  add_product(-1.0, v, along, 1.0, w);
  return along;
}

// W = Q B with Q^T M Q = 1, in place. The first `rank` columns of w become those of Q that a Gram
// matrix can tell from the others' rounding and that are not rounding next to `scale` themselves.
// |B s| is the M-norm of W s, what was left out included.
struct Orthonormalised {
  Eigen::Index rank = 0;
  Eigen::MatrixXd b;
};
Orthonormalised orthonormalise(const Pencil& pencil, ColumnsOut w, double scale, unsigned threads) {
  const Eigen::MatrixXd gram = transposed_product(w, times_mass(pencil, w, threads));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (gram + gram.transpose()));
  constexpr double kRounding = 1e-14;
  const double largest = eigen.eigenvalues().maxCoeff();
  const double least = std::max(kRounding * largest, std::pow(kRounding * scale, 2));
  Orthonormalised result;
  result.rank = (eigen.eigenvalues().array() > least).count();
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Columns old = w;
  add_product(1.0, old,
              eigen.eigenvectors().rightCols(result.rank) *
                  root.tail(result.rank).cwiseInverse().asDiagonal(),
              0.0, w.leftCols(result.rank));
  result.b = root.asDiagonal() * eigen.eigenvectors().transpose();
  return result;
}

}  // namespace

void apply_inverse(const Pencil& pencil, ColumnsOut x, unsigned threads) {
  const BlasThreads single(1);
  parallel_columns(x.cols(), kBlock, threads, [&](Eigen::Index first, Eigen::Index count) {
    SparseCholesky::Workspace workspace;
    Columns load(x.rows(), count);
    multiply(pencil.mass, x.middleCols(first, count), load);
    pencil.factor->solve(load, x.middleCols(first, count), workspace);
  });
  project_out(pencil, *pencil.deflated, x, threads);
}

LanczosPairs block_lanczos(const Pencil& pencil, int wanted, double tolerance, unsigned threads) {
  const Eigen::Index rows = pencil.mass.rows;
  const Eigen::Index most = std::min<Eigen::Index>(rows, 8 * Eigen::Index{wanted} + 20 * kBlock);
  LanczosPairs pairs;
  Columns v(rows, most);
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(most, most);  // V^T M A V
  Eigen::Index size = std::min(kBlock, most), first = 0;
  double largest = 0;
  v.leftCols(size) = start_block(rows, size);
  project_out(pencil, *pencil.deflated, v.leftCols(size), threads);
  for (int pass = 0; pass < 2; ++pass)
    size = orthonormalise(pencil, v.leftCols(size), 0.0, threads).rank;
  while (size > first) {
    const Eigen::Index width = size - first;
    Columns w = v.middleCols(first, width);
    apply_inverse(pencil, w, threads);
    pairs.solves += static_cast<int>(width);
    const Eigen::MatrixXd along = project_out(pencil, v.leftCols(size), w, threads);
    t.block(0, first, size, width) = along;
    t.block(first, 0, width, size) = along.transpose();

    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(t.topLeftCorner(size, size));
    largest = std::max(largest, ritz.eigenvalues().cwiseAbs().maxCoeff());
    const auto [next, coupling] = orthonormalise(pencil, w, largest, threads);
    if (size >= wanted) {
      const Eigen::MatrixXd chosen = ritz.eigenvectors().rightCols(wanted).rowwise().reverse();
      pairs.values = ritz.eigenvalues().tail(wanted).reverse();
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
    // A second time: what rounding left along the basis grew when directions were scaled up.
    project_out(pencil, *pencil.deflated, w.leftCols(next), threads);
    project_out(pencil, v.leftCols(size), w.leftCols(next), threads);
    const Eigen::Index kept = orthonormalise(pencil, w.leftCols(next), 0.0, threads).rank;
    v.middleCols(size, kept) = w.leftCols(kept);
    first = size;
    size += kept;
  }
  return pairs;
}

}  // namespace tremolo
