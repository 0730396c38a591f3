// LU factors and products of dense matrices, in vectors. Eigen's code is compiled for the plain
// machine, because the library must run everywhere. From 16 rows on this is faster on AVX-512, from
// 90 on it takes 0.4 to 0.2 of Eigen's time (docs/notes/performance.md, "Dense factors").
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

// P A = L U with the largest pivot of each column, like Eigen::PartialPivLU. The triangles on the
// diagonal are inverted by blocks of eight.
class DenseLu {
 public:
  DenseLu() = default;
  explicit DenseLu(const Eigen::Ref<const Eigen::MatrixXd>& a) { compute(a); }

  // a: square. Allocates only for a size above all before. A singular matrix is not detected: what
  // is solved with it is not finite or large.
  void compute(const Eigen::Ref<const Eigen::MatrixXd>& a);

  // b <- A^-1 b, of as many rows as A. Allocates only for more columns than before; one column
  // never.
  void solve_in_place(Eigen::Ref<Eigen::MatrixXd> b) const;
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

  // A^-T b. Not in vectors.
  Eigen::VectorXd solve_transposed(const Eigen::VectorXd& b) const;

  // The sign of the determinant, 1 or -1; a determinant of 0 is not detected.
  int sign() const;

 private:
  std::size_t n_ = 0;
  std::size_t padded_ = 0;  // n to whole blocks; the rows and columns from n on are those of 1
  std::size_t stride_ = 0;
  AlignedDoubles entries_;        // L below the diagonal and U, by columns
  AlignedDoubles lower_, upper_;  // the inverted triangles of each block, by columns
  std::vector<std::size_t> swaps_;
  mutable AlignedDoubles right_;
};

// A matrix by columns with whole vectors of rows, zeros behind the last: what is multiplied in
// vectors.
class PaddedMatrix {
 public:
  PaddedMatrix() = default;
  PaddedMatrix(Eigen::Index rows, Eigen::Index columns) { resize(rows, columns); }

  // Entries are zero afterwards.
  void resize(Eigen::Index rows, Eigen::Index columns);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index columns() const { return columns_; }

  using Map = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;
  using ConstMap = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;
  Map matrix() { return {entries_.data(), rows_, columns_, Eigen::OuterStride<>(stride_)}; }
  ConstMap matrix() const {
    return {entries_.data(), rows_, columns_, Eigen::OuterStride<>(stride_)};
  }

  // this -= A B. Nothing is allocated.
  void subtract_product(const PaddedMatrix& a, const PaddedMatrix& b);

 private:
  Eigen::Index rows_ = 0, columns_ = 0, stride_ = 0;
  AlignedDoubles entries_;
};

}  // namespace tremolo
