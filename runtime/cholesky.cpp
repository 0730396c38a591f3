#include "runtime/cholesky.h"

#include <algorithm>
#include <cmath>

#include "runtime/clones.h"
#include "runtime/lanes.h"
#include "runtime/triangle_product.h"

namespace tremolo {
namespace {

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::store;
using lanes::Vector;
using std::size_t;

// Column by column from the left: what column j needs of the earlier ones is summed in registers,
// four vectors at a time. columns: A's lower triangle, padded, becomes L with its unit diagonal.
// rows: row j holds L_jk d_k for k < j. False at a pivot that is not positive.
TREMOLO_CLONES bool factor(size_t n, size_t stride, const double* masks, double* columns,
                           double* rows, double* inverse) {
  for (size_t j = 0; j < n; ++j) {
    double* column = columns + j * stride;
    const double* row = rows + j * stride;
    const size_t first = j / kLanes * kLanes;
    for (size_t t = first; t < n; t += 4 * kLanes) {
      const size_t rest = (n - t + kLanes - 1) / kLanes;
      Vector even[4] = {}, odd[4] = {};
#pragma GCC unroll 4
      for (size_t c = 0; c < 4; ++c)
        if (c < rest) even[c] = load(column + t + c * kLanes);
      for (size_t k = 0; k < j; k += 2) {
        // A row ends in a zero, so that an odd count needs no case of its own.
        const Vector one = all(row[k]), two = all(row[k + 1]);
        const double* from = columns + k * stride + t;
#pragma GCC unroll 4
        for (size_t c = 0; c < 4; ++c) {
          if (c >= rest) continue;
          even[c] -= load(from + c * kLanes) * one;
          odd[c] -= load(from + stride + c * kLanes) * two;
        }
      }
#pragma GCC unroll 4
      for (size_t c = 0; c < 4; ++c)
        if (c < rest) store(column + t + c * kLanes, even[c] + odd[c]);
    }
    const double pivot = column[j];
    if (!(pivot > 0.0)) return false;
    for (size_t i = j + 1; i < n; ++i) rows[i * stride + j] = column[i];
    inverse[j] = 1.0 / pivot;
    const Vector scale = all(inverse[j]);
    store(column + first,
          lanes::without(load(column + first), load(masks + (j - first) * kLanes)) * scale);
    for (size_t t = first + kLanes; t < n; t += kLanes) store(column + t, load(column + t) * scale);
  }
  return std::isfinite(inverse[n - 1]);
}

TREMOLO_CLONES void solve_both(size_t n, size_t stride, const double* columns, const double* rows,
                               const double* inverse, double* x) {
  // Column k has a one at k: what becomes of x_k there is put right at the end.
  double* solved = x + stride;
  for (size_t k = 0; k < n; ++k) {
    solved[k] = x[k];
    const Vector factor = all(x[k]);
    const double* column = columns + k * stride;
    for (size_t t = k / kLanes * kLanes; t < n; t += kLanes)
      store(x + t, load(x + t) - load(column + t) * factor);
  }
  for (size_t t = 0; t < n; t += kLanes) store(x + t, load(solved + t));
  for (size_t k = n; k-- > 0;) {
    const double value = x[k] * inverse[k];
    const Vector factor = all(value);
    const double* row = rows + k * stride;
    for (size_t t = 0; t < k; t += kLanes) store(x + t, load(x + t) - load(row + t) * factor);
    solved[k] = value;
  }
}

}  // namespace

SmallCholesky::SmallCholesky(Eigen::Index size)
    : n_(static_cast<size_t>(size)),
      stride_(lanes::padded(n_ + 1)),
      masks_(lane_masks()),
      columns_(n_ * stride_, 0.0),
      rows_(n_ * stride_, 0.0),
      inverse_(stride_, 0.0),
      scratch_(2 * stride_, 0.0) {}

bool SmallCholesky::compute(const Eigen::MatrixXd& a) {
  if (n_ == 0) return true;
  for (size_t j = 0; j < n_; ++j)
    std::copy(a.data() + j * n_ + j, a.data() + (j + 1) * n_, columns_.data() + j * stride_ + j);
  return factor(n_, stride_, masks_.data(), columns_.data(), rows_.data(), inverse_.data());
}

void SmallCholesky::solve(Eigen::VectorXd& x) const {
  if (n_ == 0) return;
  std::copy(x.data(), x.data() + n_, scratch_.begin());
  solve_both(n_, stride_, columns_.data(), rows_.data(), inverse_.data(), scratch_.data());
  std::copy_n(scratch_.data() + stride_, n_, x.data());
}

}  // namespace tremolo
