#include <algorithm>
#include <cmath>

#include "runtime/math/dense/small_matrices.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// The arrays of a SmallCholesky, each aligned to 64 bytes; columns and rows `stride` apart.
template <class Number>
struct LdlArrays {
  std::size_t stride;
  Number* columns;
  Number* rows;
  Number* inverse;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/dense/cholesky.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using std::size_t;

namespace {

// Reads the lower triangle up to the first entry that is not zero.
bool is_diagonal(const Eigen::MatrixXd& a) {
  for (Eigen::Index j = 0; j + 1 < a.cols(); ++j)
    if (!a.col(j).tail(a.rows() - j - 1).isZero(0.0)) return false;
  return true;
}

}  // namespace

SmallCholesky::SmallCholesky(Eigen::Index size)
    : n_(static_cast<size_t>(size)),
      stride_(padded(n_ + 1)),
      columns_(n_ * stride_, 0.0),
      rows_(n_ * stride_, 0.0),
      inverse_(stride_, 0.0),
      scratch_(2 * stride_, 0.0) {}

bool SmallCholesky::compute(const Eigen::MatrixXd& a) {
  if (n_ == 0) return true;
  diagonal_ = is_diagonal(a);
  if (diagonal_) {
    for (size_t j = 0; j < n_; ++j) inverse_[j] = 1.0 / a.data()[j * (n_ + 1)];
    return std::all_of(inverse_.begin(), inverse_.begin() + static_cast<std::ptrdiff_t>(n_),
                       [](double x) { return x > 0.0 && std::isfinite(x); });
  }
  for (size_t j = 0; j < n_; ++j)
    std::copy(a.data() + j * n_ + j, a.data() + (j + 1) * n_, columns_.data() + j * stride_ + j);
  return TREMOLO_CALL(factor, {stride_, columns_.data(), rows_.data(), inverse_.data()}, n_);
}

void SmallCholesky::solve(Eigen::VectorXd& x) const {
  if (n_ == 0) return;
  if (diagonal_) {
    for (size_t j = 0; j < n_; ++j) x.data()[j] *= inverse_[j];
    return;
  }
  std::copy(x.data(), x.data() + n_, scratch_.begin());
  TREMOLO_CALL(solve_both, {stride_, columns_.data(), rows_.data(), inverse_.data()}, n_,
               scratch_.data());
  std::copy_n(scratch_.data() + stride_, n_, x.data());
}

}  // namespace tremolo
