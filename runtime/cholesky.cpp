#include "runtime/cholesky.h"

#include <algorithm>
#include <cmath>

#include "runtime/clones.h"
#include "runtime/lanes.h"

namespace tremolo {
namespace {

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::store;
using lanes::Vector;
using std::size_t;

// Column by column from the left: what column j needs of the earlier ones is summed in registers,
// four vectors at a time. False at a pivot that is not positive.
TREMOLO_CLONES bool factor(const double* a, size_t n, size_t stride, double* lower, double* upper,
                           double* inverse) {
  for (size_t j = 0; j < n; ++j) {
    double* column = lower + j * stride;
    const size_t first = j / kLanes * kLanes;
    for (size_t i = j; i < n; ++i) column[i] = a[j * n + i];
    const double* row = upper + j * stride;  // L_jk for k < j
    for (size_t t = first; t < n; t += 4 * kLanes) {
      const size_t rest = (n - t + kLanes - 1) / kLanes;
      Vector even[4], odd[4] = {};
      for (size_t c = 0; c < 4; ++c) even[c] = c < rest ? load(column + t + c * kLanes) : Vector{};
      const auto subtract = [&](size_t k, Vector * part) __attribute__((always_inline)) {
        const Vector factor = all(row[k]);
        const double* from = lower + k * stride + t;
        part[0] -= load(from) * factor;
        if (rest > 1) part[1] -= load(from + kLanes) * factor;
        if (rest > 2) part[2] -= load(from + 2 * kLanes) * factor;
        if (rest > 3) part[3] -= load(from + 3 * kLanes) * factor;
      };
      size_t k = 0;
      for (; k + 2 <= j; k += 2) {
        subtract(k, even);
        subtract(k + 1, odd);
      }
      if (k < j) subtract(k, even);
      for (size_t c = 0; c < 4 && c < rest; ++c) store(column + t + c * kLanes, even[c] + odd[c]);
    }
    const double pivot = column[j];
    if (!(pivot > 0.0)) return false;
    inverse[j] = 1.0 / std::sqrt(pivot);
    for (size_t i = first; i < j; ++i) column[i] = 0.0;
    const Vector scale = all(inverse[j]);
    for (size_t t = first; t < n; t += kLanes) store(column + t, load(column + t) * scale);
    for (size_t i = n; i < stride; ++i) column[i] = 0.0;
    for (size_t i = j; i < n; ++i) upper[i * stride + j] = column[i];
  }
  return std::isfinite(inverse[n - 1]);
}

TREMOLO_CLONES void solve_both(size_t n, size_t stride, const double* lower, const double* upper,
                               const double* inverse, double* x) {
  for (size_t k = 0; k < n; ++k) {
    const double value = x[k] * inverse[k];
    const Vector factor = all(value);
    const double* column = lower + k * stride;
    for (size_t t = k / kLanes * kLanes; t < n; t += kLanes)
      store(x + t, load(x + t) - load(column + t) * factor);
    x[k] = value;
  }
  for (size_t k = n; k-- > 0;) {
    const double value = x[k] * inverse[k];
    const Vector factor = all(value);
    const double* column = upper + k * stride;
    for (size_t t = 0; t <= k; t += kLanes) store(x + t, load(x + t) - load(column + t) * factor);
    x[k] = value;
  }
}

}  // namespace

SmallCholesky::SmallCholesky(Eigen::Index size)
    : n_(static_cast<size_t>(size)),
      stride_(lanes::padded(n_)),
      lower_(n_ * stride_ + 4 * kLanes, 0.0),
      upper_(n_ * stride_, 0.0),
      inverse_(stride_, 0.0),
      scratch_(stride_, 0.0) {}

bool SmallCholesky::compute(const Eigen::MatrixXd& a) {
  if (n_ == 0) return true;
  return factor(a.data(), n_, stride_, lower_.data(), upper_.data(), inverse_.data());
}

void SmallCholesky::solve(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + n_, scratch_.begin());
  solve_both(n_, stride_, lower_.data(), upper_.data(), inverse_.data(), scratch_.data());
  std::copy(scratch_.begin(), scratch_.begin() + static_cast<std::ptrdiff_t>(n_), x.data());
}

}  // namespace tremolo
