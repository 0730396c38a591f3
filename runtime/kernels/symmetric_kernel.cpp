#include "runtime/kernels/symmetric_kernel.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"
#include "runtime/kernels/lanes.h"

namespace tremolo {
namespace {

// One of two points that are evaluated together: what symmetric_kernel.h calls q, x, E, W and W_.r.
struct Point {
  const double* point;
  const double* pairs;
  double* e;
  double* w;
  double* last;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/kernels/symmetric_kernel.inc"
#include "runtime/kernels/every_machine.inc"

namespace tremolo {
namespace {

using lanes::kLanes;
using lanes::padded;
using plain::for_each_group;
using plain::padded_pairs;
using std::size_t;

// ---- storage ----

struct RowWriter {
  size_t r;
  std::span<const double> cubic;
  std::span<const double> quartic;
  AlignedDoubles& rows;

  void one(size_t k, size_t l, size_t count) {
    const size_t first = rows.size();
    rows.resize(first + count * padded_pairs(k), 0.0);
    for (size_t b = 0; b < count; ++b) put(first, count, b, k, l + b);
  }
  void two(size_t k, size_t l) {
    const size_t first = rows.size();
    rows.resize(first + 8 * padded_pairs(k), 0.0);
    for (size_t b = 0; b < 8; ++b) put(first, 8, b, b < 4 ? k : k - 1, l + b % 4);
  }
  // Row (k, l) as the `place`-th of `count` that lie interleaved from `first` on.
  void put(size_t first, size_t count, size_t place, size_t k, size_t l) {
    for (size_t j = 0; j <= k; ++j)
      for (size_t i = 0; i <= j; ++i) {
        const size_t at = pair_index(i, j);
        rows[first + (at / kLanes * count + place) * kLanes + at % kLanes] =
            l == r ? orderings(i, j, k) * cubic[triple_index(i, j, k)]
                   : orderings(i, j, k, l) * quartic[quad_index(i, j, k, l)];
      }
  }
};

}  // namespace

SymmetricKernel::SymmetricKernel(size_t r, std::span<const double> cubic,
                                 std::span<const double> quartic)
    : r_(r), stride_(padded_pairs(padded(r) - 1) + kLanes), masks_(lane_masks()) {
  RowWriter writer{r, cubic, quartic, rows_};
  for_each_group(r, writer);
}

SymmetricKernel::Workspace SymmetricKernel::make_workspace() const {
  Workspace workspace;
  // Columns up to the next whole group are read and masked out.
  const size_t pairs = padded(pair_count(padded(r_))) + kLanes;
  workspace.point.assign(padded(r_ + 1) + kLanes, 0.0);
  workspace.pairs.assign(pairs, 0.0);
  workspace.folded.assign(pairs, 0.0);
  workspace.sums.assign(pairs, 0.0);
  workspace.last.assign(padded(r_), 0.0);
  workspace.thirds.assign(r_ * stride_ + pairs, 0.0);
  workspace.column.assign(padded(r_), 0.0);
  return workspace;
}

double SymmetricKernel::gradient(const double* q, Workspace& w, double* gradient) const {
  return (*TREMOLO_BEST(evaluate_gradient))(rows_.data(), r_, q, w.point.data(), w.pairs.data(),
                                            w.folded.data(), w.sums.data(), w.last.data(),
                                            masks_.data(), w.column.data(), gradient);
}

void SymmetricKernel::gradient_pair(const double* q0, const double* q1, Workspace& w0,
                                    Workspace& w1, double* gradient0, double* gradient1) const {
  const auto point = [](Workspace& w) {
    return Point{w.point.data(), w.pairs.data(), w.folded.data(), w.sums.data(), w.last.data()};
  };
  const auto finish = [this](Workspace& w, double* gradient) {
    (*TREMOLO_BEST(finish_gradient))(r_, w.point.data(), w.pairs.data(), w.folded.data(),
                                     w.sums.data(), w.last.data(), masks_.data(), w.column.data(),
                                     gradient);
  };
  (*TREMOLO_BEST(prepare_point))(q0, r_, w0.point.data(), w0.pairs.data());
  (*TREMOLO_BEST(prepare_point))(q1, r_, w1.point.data(), w1.pairs.data());
  (*TREMOLO_BEST(gradient_sums_twice))(rows_.data(), r_, point(w0), point(w1));
  finish(w0, gradient0);
  finish(w1, gradient1);
}

double SymmetricKernel::hessian(const double* q, Workspace& w, double* gradient,
                                double* hessian) const {
  const double value = (*TREMOLO_BEST(evaluate_hessian))(
      rows_.data(), r_, stride_, q, w.point.data(), w.pairs.data(), w.folded.data(), w.sums.data(),
      w.last.data(), w.thirds.data(), masks_.data(), w.column.data(), gradient, hessian);
  // What lies behind each Z^k must stay zero.
  if (!std::isfinite(value)) std::fill(w.thirds.begin(), w.thirds.end(), 0.0);
  return value;
}

}  // namespace tremolo
