// Small dense matrices in vectors: the factor of a symmetric one, products with tall ones.
#pragma once

#include <span>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {

// Cholesky's factor of a small symmetric positive definite matrix, in vectors. Eigen's code is
// compiled for the plain machine, because the library must run everywhere.

// A = L D L^T, L with a unit diagonal: the same without roots. A diagonal A, as in every step of a
// linear model, is its own D: it is detected, and costs no products. The constructor allocates all
// memory.
class SmallCholesky {
 public:
  explicit SmallCholesky(Eigen::Index size);

  // a: size x size, its lower triangle is read. False, and no solve until the next, if A is not
  // positive definite or not finite.
  bool compute(const Eigen::MatrixXd& a);

  // x <- A^-1 x.
  void solve(Eigen::VectorXd& x) const;

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(diagonal_, columns_, rows_, inverse_); }

 private:
  std::size_t n_;
  std::size_t stride_;
  bool diagonal_ = false;
  AlignedDoubles columns_;  // L column by column, padded, zeros above the diagonal
  AlignedDoubles rows_;     // L D row by row, without the diagonal
  AlignedDoubles inverse_;  // of D
  mutable AlignedDoubles scratch_;
};

// Products with matrices that consist of several square ones below each other, and sums of such
// blocks, in vectors.

// The number of stored rows of a tall matrix of `rows` rows: the next multiple of a vector's
// length. Entries of padding rows are finite.
Eigen::Index tall_rows(Eigen::Index rows);

// The first tall_rows(rows) entries of y become those of A x. a: stored with at least as many rows,
// by columns, x: one entry a column, y: at least tall_rows(rows) long. Nothing is allocated.
void multiply_tall(const Eigen::MatrixXd& a, Eigen::Index rows, const Eigen::VectorXd& x,
                   Eigen::VectorXd& y);

// sum += sum_b weights[b] A_b, A_b the rows b r .. b r + r - 1 of a, r its number of columns. a:
// stored with at least tall_rows(r) rows from the start of its last block; sum: tall_rows(r) x r,
// whose last rows are undefined. Nothing is allocated.
void add_blocks(const Eigen::MatrixXd& a, std::span<const double> weights, Eigen::MatrixXd& sum);

}  // namespace tremolo
