#include "runtime/math/kernels/symmetric_kernel.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// The rows of a SymmetricKernel: c_ijkl.
struct UniqueRows {
  const double* c;
  std::size_t r;
  std::size_t z_stride;
};

// The arrays of a Workspace, each aligned to 64 bytes.
struct PointSums {
  double* q;
  double* x;
  double* e;
  double* w;
  double* w_r;
  double* z;
  double* y;
};

struct GradientAt {
  const double* q;
  PointSums at;
  double* gradient;
};

PointSums sums_in(SymmetricKernel::Workspace& w) {
  return {w.q.data(), w.x.data(), w.e.data(), w.w.data(), w.w_r.data(), w.z.data(), w.y.data()};
}

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/kernels/symmetric_kernel.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

using plain::padded_pairs;
using std::size_t;

// Appends the rows that for_each_group visits.
struct RowWriter {
  size_t r;
  std::span<const double> cubic;
  std::span<const double> quartic;
  AlignedDoubles& rows;

  template <size_t Rows, bool Diagonal>
  void one(size_t k, size_t l) {
    const size_t first = append(Rows, k);
    for (size_t b = 0; b < Rows; ++b) put(first, Rows, b, k, l + b);
  }
  void two(size_t k, size_t l) {
    const size_t first = append(8, k);
    for (size_t b = 0; b < 8; ++b) put(first, 8, b, b < 4 ? k : k - 1, l + b % 4);
  }
  size_t append(size_t count, size_t k) {
    const size_t first = rows.size();
    rows.resize(first + count * padded_pairs(k), 0.0);
    return first;
  }
  // Row (k, l) as the `place`-th of `count` rows that lie interleaved from `first` on.
  void put(size_t first, size_t count, size_t place, size_t k, size_t l) {
    for (size_t j = 0; j <= k; ++j)
      for (size_t i = 0; i <= j; ++i) {
        const size_t at = pair_index(i, j);
        rows[first + (at / kVectorLanes * count + place) * kVectorLanes + at % kVectorLanes] =
            l == r ? orderings(i, j, k) * cubic[triple_index(i, j, k)]
                   : orderings(i, j, k, l) * quartic[quad_index(i, j, k, l)];
      }
  }
};

}  // namespace

SymmetricKernel::SymmetricKernel(size_t r, std::span<const double> cubic,
                                 std::span<const double> quartic)
    : r_(r), z_stride_(padded_pairs(padded(r) - 1) + kVectorLanes) {
  RowWriter writer{r, cubic, quartic, rows_};
  plain::for_each_group(r, writer);
}

SymmetricKernel::Workspace SymmetricKernel::make_workspace() const {
  Workspace workspace;
  // Columns up to the next whole group are read and masked out.
  const size_t pairs = padded(pair_count(padded(r_))) + kVectorLanes;
  workspace.q.assign(padded(r_ + 1) + kVectorLanes, 0.0);
  for (AlignedDoubles* array : {&workspace.x, &workspace.e, &workspace.w})
    array->assign(pairs, 0.0);
  for (AlignedDoubles* array : {&workspace.w_r, &workspace.y}) array->assign(padded(r_), 0.0);
  workspace.z.assign(r_ * z_stride_ + pairs, 0.0);
  return workspace;
}

double SymmetricKernel::value(const double* q, Workspace& workspace) const {
  const UniqueRows rows{rows_.data(), r_, z_stride_};
  return TREMOLO_CALL(evaluate_value, rows, q, sums_in(workspace));
}

double SymmetricKernel::gradient(const double* q, Workspace& workspace, double* gradient) const {
  const UniqueRows rows{rows_.data(), r_, z_stride_};
  return TREMOLO_CALL(evaluate_gradient, rows, q, sums_in(workspace), gradient);
}

void SymmetricKernel::gradient_pair(const double* q0, const double* q1, Workspace& workspace0,
                                    Workspace& workspace1, double* gradient0,
                                    double* gradient1) const {
  const UniqueRows rows{rows_.data(), r_, z_stride_};
  const GradientAt points[] = {{q0, sums_in(workspace0), gradient0},
                               {q1, sums_in(workspace1), gradient1}};
  TREMOLO_CALL(evaluate_two_gradients, rows, points);
}

double SymmetricKernel::hessian(const double* q, Workspace& workspace, double* gradient,
                                double* hessian) const {
  const UniqueRows rows{rows_.data(), r_, z_stride_};
  const double value =
      TREMOLO_CALL(evaluate_hessian, rows, q, sums_in(workspace), gradient, hessian);
  // The padding after each Z^k must stay zero.
  if (!std::isfinite(value)) std::fill(workspace.z.begin(), workspace.z.end(), 0.0);
  return value;
}

}  // namespace tremolo
