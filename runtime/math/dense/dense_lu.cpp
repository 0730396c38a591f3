#include "runtime/math/dense/dense_lu.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

constexpr std::size_t kLuBlock = 8;

// Entries by columns, `stride` apart; the first is aligned to a vector.
template <class Number>
struct BlockOf {
  Number* entries;
  std::size_t stride;

  Number* at(std::size_t i, std::size_t j) const { return entries + j * stride + i; }
  BlockOf from(std::size_t i, std::size_t j) const { return {at(i, j), stride}; }
};
using DenseBlock = BlockOf<double>;
using ConstDenseBlock = BlockOf<const double>;

struct DenseSizes {
  std::size_t rows, columns, depth;
};

// The arrays of a DenseLu. n: rows, padded: to whole blocks.
struct LuArrays {
  std::size_t n, padded, stride;
  double* a;
  double* lower;
  double* upper;
  std::size_t* swaps;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/dense/dense_lu.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::size_t;

namespace {

// Columns that are a multiple of 4 kB apart would share the same few lines of the cache.
size_t stride_of(size_t rows) {
  const size_t whole = (rows + kLuBlock - 1) / kLuBlock * kLuBlock;
  return whole % 64 == 0 ? whole + kLuBlock : whole;
}

}  // namespace

void DenseLu::compute(const Eigen::Ref<const MatrixXd>& a) {
  n_ = static_cast<size_t>(a.rows());
  padded_ = (n_ + kLuBlock - 1) / kLuBlock * kLuBlock;
  stride_ = stride_of(n_);
  entries_.resize(stride_ * padded_);
  lower_.resize(padded_ * kLuBlock);
  upper_.resize(padded_ * kLuBlock);
  swaps_.resize(padded_);
  if (right_.size() < stride_) right_.resize(stride_);
  for (size_t j = 0; j < padded_; ++j) {
    double* column = entries_.data() + j * stride_;
    const size_t given = j < n_ ? n_ : 0;
    if (given > 0) std::copy_n(a.col(static_cast<Index>(j)).data(), n_, column);
    std::fill(column + given, column + stride_, 0.0);
    if (j >= n_) column[j] = 1.0;
  }
  const LuArrays lu{n_,           padded_, stride_, entries_.data(), lower_.data(), upper_.data(),
                    swaps_.data()};
  TREMOLO_CALL(factor_lu, lu);
}

void DenseLu::solve_in_place(Eigen::Ref<MatrixXd> b) const {
  const auto columns = static_cast<size_t>(b.cols());
  if (right_.size() < stride_ * columns) right_.resize(stride_ * columns);
  for (size_t j = 0; j < columns; ++j) {
    double* to = right_.data() + j * stride_;
    std::copy_n(b.col(static_cast<Index>(j)).data(), n_, to);
    std::fill(to + n_, to + stride_, 0.0);
  }
  // The kernel only reads the factor.
  const LuArrays lu{n_,
                    padded_,
                    stride_,
                    const_cast<double*>(entries_.data()),
                    const_cast<double*>(lower_.data()),
                    const_cast<double*>(upper_.data()),
                    const_cast<size_t*>(swaps_.data())};
  TREMOLO_CALL(solve_lu, lu, DenseBlock{right_.data(), stride_}, columns);
  for (size_t j = 0; j < columns; ++j)
    std::copy_n(right_.data() + j * stride_, n_, b.col(static_cast<Index>(j)).data());
}

VectorXd DenseLu::solve(const VectorXd& b) const {
  VectorXd result = b;
  solve_in_place(result);
  return result;
}

VectorXd DenseLu::solve_transposed(const VectorXd& b) const {
  const auto n = static_cast<Index>(n_);
  const Eigen::Map<const MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>> lu(
      entries_.data(), n, n, Eigen::OuterStride<>(static_cast<Index>(stride_)));
  VectorXd result = b;
  lu.triangularView<Eigen::Upper>().transpose().solveInPlace(result);
  lu.triangularView<Eigen::UnitLower>().transpose().solveInPlace(result);
  for (size_t k = n_; k-- > 0;)
    std::swap(result[static_cast<Index>(k)], result[static_cast<Index>(swaps_[k])]);
  return result;
}

int DenseLu::sign() const {
  int sign = 1;
  for (size_t k = 0; k < n_; ++k) {
    if (swaps_[k] != k) sign = -sign;
    if (entries_[k * stride_ + k] < 0.0) sign = -sign;
  }
  return sign;
}

void PaddedMatrix::resize(Index rows, Index columns) {
  rows_ = rows;
  columns_ = columns;
  stride_ = static_cast<Index>(stride_of(static_cast<size_t>(rows)));
  entries_.assign(static_cast<size_t>(stride_ * columns), 0.0);
}

void PaddedMatrix::subtract_product(const PaddedMatrix& a, const PaddedMatrix& b) {
  const DenseSizes sizes{padded(static_cast<size_t>(rows_)), static_cast<size_t>(columns_),
                         static_cast<size_t>(a.columns_)};
  const DenseBlock c{entries_.data(), static_cast<size_t>(stride_)};
  const ConstDenseBlock left{a.entries_.data(), static_cast<size_t>(a.stride_)};
  const ConstDenseBlock right{b.entries_.data(), static_cast<size_t>(b.stride_)};
  TREMOLO_CALL(subtract_product, c, left, right, sizes);
}

}  // namespace tremolo
