#include "runtime/bodies/lanes/lane_segment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

using std::size_t;

constexpr size_t kGroup = 8;  // rows of the matrix that are stored together

// Triples (j, k, l) with the same j and k that evaluate_mean() computes together: the sums of two
// points for four of them still fit in the registers of AVX2.
constexpr size_t kTogether = 4;

// The number of the `left` values of l in the next step of evaluate_mean().
constexpr size_t next_width(size_t left) {
  const size_t steps = (left + kTogether - 1) / kTogether;
  return (left + steps - 1) / steps;
}

constexpr size_t padded_rows(size_t modes) {
  return segment_scratch_rows(modes) / 2;
}

// Arguments of a pass.
template <class Real>
struct SegmentTask {
  size_t modes;
  const Real* coefficients;
  const Real* middle;
  const Real* half;
  Real* scratch;
  Real* mean;
  Real* tangent;
};

// The rows of a block, kBytes of each.
template <class Real, int kBytes>
struct Rows {
  typedef Real Vector __attribute__((vector_size(kBytes), may_alias));
  static constexpr size_t kStride = kBodiesPerBlock<Real>;

  Real* first;
  [[gnu::always_inline]] inline Vector& operator[](size_t row) const {
    return *reinterpret_cast<Vector*>(first + row * kStride);
  }
};

template <class Real, int kBytes>
struct ConstRows {
  typedef Real Vector __attribute__((vector_size(kBytes), may_alias));
  static constexpr size_t kStride = kBodiesPerBlock<Real>;

  const Real* first;
  [[gnu::always_inline]] inline const Vector& operator[](size_t row) const {
    return *reinterpret_cast<const Vector*>(first + row * kStride);
  }
};

// y = M x for the groups of rows up to `groups`.
template <int kBytes, class Real>
[[gnu::always_inline]] inline void multiply(const Real* matrix, size_t groups,
                                            ConstRows<Real, kBytes> x, Rows<Real, kBytes> y) {
  typedef typename Rows<Real, kBytes>::Vector Vector;
  constexpr size_t kAtOnce = kBytes == 64 ? kGroup : kGroup / 2;  // rows in registers
  for (size_t group = 0; group < groups; ++group) {
    const size_t first = group * kGroup;
    for (size_t part = 0; part < kGroup; part += kAtOnce) {
      const Real* c = matrix + part;
      Vector sum[kAtOnce], own[kAtOnce];
      for (size_t m = 0; m < kAtOnce; ++m) {
        sum[m] = Vector{};
        own[m] = x[first + part + m];
      }
      for (size_t b = 0; b < first; ++b, c += kGroup) {
        const Vector x_b = x[b];
        Vector mirrored[2];  // two sums, so that the chain of additions is short
        for (size_t m = 0; m < kAtOnce; ++m) {
          const Vector c_m = c[m] - Vector{};  // minus zero: a broadcast and nothing else
          sum[m] += c_m * x_b;
          if (m < 2)
            mirrored[m] = c_m * own[m];
          else
            mirrored[m % 2] += c_m * own[m];
        }
        y[b] += mirrored[0] + mirrored[1];
      }
      for (size_t b = first; b < first + kGroup; ++b, c += kGroup)
        for (size_t m = 0; m < kAtOnce; ++m) sum[m] += c[m] * x[b];
      for (size_t m = 0; m < kAtOnce; ++m) y[first + part + m] = sum[m];
    }
    matrix += kGroup * (first + kGroup);
  }
}

template <int kBytes, class Real>
[[gnu::always_inline]] inline void run_segment(const SegmentTask<Real>& given) {
  typedef typename Rows<Real, kBytes>::Vector Vector;
  const SegmentTask<Real> task = given;
  const size_t r = task.modes, rows = padded_rows(r);
  constexpr size_t kAtOnce = static_cast<size_t>(kBytes) / sizeof(Real);
  for (size_t lane = 0; lane < kBodiesPerBlock<Real>; lane += kAtOnce) {
    const ConstRows<Real, kBytes> m{task.middle + lane}, s{task.half + lane};
    const Rows<Real, kBytes> x{task.scratch + lane},
        y{task.scratch + rows * kBodiesPerBlock<Real> + lane};
    const Rows<Real, kBytes> mean{task.mean + lane}, tangent{task.tangent + lane};
    for (size_t i = 0; i < r; ++i) x[i] = m[i];
    size_t at = r;
    for (size_t j = 0; j < r; ++j) {
      const Vector m_j = m[j] + m[j], s_j = s[j] + s[j];
      for (size_t i = 0; i < j; ++i) x[at++] = m_j * m[i] + s_j * s[i];
      x[at++] = m[j] * m[j] + s[j] * s[j];
    }
    for (; at < rows; ++at) x[at] = Vector{};
    multiply<kBytes>(task.coefficients, rows / kGroup, ConstRows<Real, kBytes>{x.first}, y);
    for (size_t i = 0; i < r; ++i) mean[i] = Real(0.5) * y[i];
    at = r;
    size_t to = 0;
    for (size_t j = 0; j < r; ++j) {
      Vector sum = Vector{};
      const Vector m_j = m[j];
      for (size_t i = 0; i < j; ++i, ++at) {
        const Vector a = y[at];
        sum += a * m[i];
        mean[i] += a * m_j;
        tangent[to++] = Real(12) * a;
      }
      const Vector a = y[at++];
      mean[j] += sum + a * m_j;
      tangent[to++] = Real(12) * a;
    }
    for (size_t i = 0; i < r; ++i) mean[i] *= Real(4);
  }
}

// The pass of lane_force.cpp at two points, which share the gradient.
template <class Real, int kBytes>
struct MeanPass {
  typedef Real Vector __attribute__((vector_size(kBytes), may_alias));

  const Real* coefficient;
  ConstRows<Real, kBytes> x, y;  // the two points
  Rows<Real, kBytes> gradient;   // the sum of theirs

  // All (j <= k, k, l) for l in [first, first + kWidth).
  template <size_t kWidth>
  [[gnu::always_inline]] inline void add_triples(size_t k, size_t first) {
    Vector x_pair[kWidth], y_pair[kWidth], x_adjoint[kWidth], y_adjoint[kWidth];
    for (size_t m = 0; m < kWidth; ++m) {
      x_pair[m] = x[k] * x[first + m];
      y_pair[m] = y[k] * y[first + m];
      x_adjoint[m] = y_adjoint[m] = Vector{};
    }
    const Real* c = coefficient;
    for (size_t j = 0; j <= k; ++j) {
      Vector s[kWidth], u[kWidth], t[kWidth];
      for (size_t m = 0; m < kWidth; ++m) {
        s[m] = u[m] = Vector{} + c[m];
        t[m] = x[j] * x_pair[m] + y[j] * y_pair[m];
      }
      c += kWidth;
      for (size_t i = 0; i <= j; ++i, c += kWidth) {
        const Vector x_i = x[i], y_i = y[i];
        Vector sum;
        for (size_t m = 0; m < kWidth; ++m) {
          const Vector c_m = c[m] - Vector{};  // minus zero: a broadcast and nothing else
          s[m] += c_m * x_i;
          u[m] += c_m * y_i;
          if (m == 0)
            sum = c_m * t[m];
          else
            sum += c_m * t[m];
        }
        gradient[i] += sum;
      }
      const Vector x_j = x[j], y_j = y[j];
      Vector sum = s[0] * x_pair[0] + u[0] * y_pair[0];
      for (size_t m = 0; m < kWidth; ++m) {
        if (m > 0) sum += s[m] * x_pair[m] + u[m] * y_pair[m];
        x_adjoint[m] += s[m] * x_j;
        y_adjoint[m] += u[m] * y_j;
      }
      gradient[j] += sum;
    }
    coefficient = c;
    Vector sum = x_adjoint[0] * x[first] + y_adjoint[0] * y[first];
    for (size_t m = 1; m < kWidth; ++m)
      sum += x_adjoint[m] * x[first + m] + y_adjoint[m] * y[first + m];
    gradient[k] += sum;
    for (size_t m = 0; m < kWidth; ++m)
      gradient[first + m] += x_adjoint[m] * x[k] + y_adjoint[m] * y[k];
  }

  [[gnu::always_inline]] inline void add_wide(size_t width, size_t k, size_t l) {
    switch (width) {
      case 1:
        return add_triples<1>(k, l);
      case 2:
        return add_triples<2>(k, l);
      case 3:
        return add_triples<3>(k, l);
      default:
        return add_triples<kTogether>(k, l);
    }
  }
};

template <int kBytes, class Real>
[[gnu::always_inline]] inline void run_mean(const SegmentTask<Real>& given) {
  typedef typename Rows<Real, kBytes>::Vector Vector;
  const SegmentTask<Real> task = given;
  const size_t r = task.modes;
  constexpr Real kPoint = Real(1.0 / std::numbers::sqrt3);
  constexpr size_t kAtOnce = static_cast<size_t>(kBytes) / sizeof(Real);
  for (size_t lane = 0; lane < kBodiesPerBlock<Real>; lane += kAtOnce) {
    const ConstRows<Real, kBytes> m{task.middle + lane}, s{task.half + lane};
    const Rows<Real, kBytes> x{task.scratch + lane},
        y{task.scratch + r * kBodiesPerBlock<Real> + lane}, mean{task.mean + lane};
    for (size_t i = 0; i < r; ++i) {
      x[i] = m[i] + kPoint * s[i];
      y[i] = m[i] - kPoint * s[i];
      mean[i] = Vector{};
    }
    MeanPass<Real, kBytes> pass{task.coefficients, ConstRows<Real, kBytes>{x.first},
                                ConstRows<Real, kBytes>{y.first}, mean};
    for (size_t k = 0; k < r; ++k)
      for (size_t l = k; l < r;) {
        const size_t width = next_width(r - l);
        pass.add_wide(width, k, l);
        l += width;
      }
    for (size_t i = 0; i < r; ++i) mean[i] *= Real(0.5);
  }
}

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/bodies/lanes/lane_segment.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

// The entry of the matrix of the header at a row and a column before or on it.
struct MatrixEntries {
  size_t r;
  std::span<const double> cubic, quartic;  // empty: a linear solid
  double cubic_factor, quartic_factor;
  std::vector<size_t> first, second;  // i and j of each pair

  double operator()(size_t row, size_t column) const {
    if (row < r || row >= r + first.size() || cubic.empty()) return 0.0;
    const size_t i = first[row - r], j = second[row - r];
    if (column < r) return 0.5 * cubic_factor * cubic[triple_index_any(column, i, j)];
    const size_t k = first[column - r], l = second[column - r];
    return quartic_factor * quartic[quad_index_any(i, j, k, l)];
  }
};

template <class Real>
void fill_matrix(const MatrixEntries& entries, SegmentCoefficients<Real>& to) {
  const size_t rows = padded_rows(entries.r);
  const size_t used = entries.r + entries.first.size();
  to.matrix.reserve(kGroup * (rows + kGroup) * rows / kGroup / 2);
  for (size_t first = 0; first < rows; first += kGroup)
    for (size_t column = 0; column < first + kGroup; ++column)
      for (size_t row = first; row < first + kGroup; ++row)
        to.matrix.push_back(
            row >= used || column >= used
                ? Real(0)
                : static_cast<Real>(entries(std::max(row, column), std::min(row, column))));
}

template <class Real>
void fill_stream(const MatrixEntries& entries, SegmentCoefficients<Real>& to) {
  const size_t r = entries.r;
  if (entries.cubic.empty()) {
    to.stream.assign(triple_count(r) + quad_count(r), Real(0));
    return;
  }
  to.stream.reserve(triple_count(r) + quad_count(r));
  for (size_t k = 0; k < r; ++k)
    for (size_t first = k; first < r;) {
      const size_t end = first + next_width(r - first);
      for (size_t j = 0; j <= k; ++j) {
        for (size_t l = first; l < end; ++l)
          to.stream.push_back(static_cast<Real>(entries.cubic_factor * orderings(j, k, l) *
                                                entries.cubic[triple_index(j, k, l)]));
        for (size_t i = 0; i <= j; ++i)
          for (size_t l = first; l < end; ++l)
            to.stream.push_back(static_cast<Real>(entries.quartic_factor * orderings(i, j, k, l) *
                                                  entries.quartic[quad_index(i, j, k, l)]));
      }
      first = end;
    }
}

}  // namespace

template <class Real>
SegmentCoefficients<Real> make_segment_coefficients(const LaneCoefficients<Real>& lanes,
                                                    std::span<const double> cubic,
                                                    std::span<const double> quartic) {
  SegmentCoefficients<Real> segment;
  segment.modes = lanes.modes;
  segment.coordinate_scale = lanes.coordinate_scale;
  segment.energy_scale = lanes.energy_scale;
  const double scale = lanes.coordinate_scale, cube = scale * scale * scale;
  MatrixEntries entries{
      lanes.modes, cubic, quartic, cube / lanes.energy_scale, cube * scale / lanes.energy_scale,
      {},          {}};
  for (size_t j = 0; j < lanes.modes; ++j)
    for (size_t i = 0; i <= j; ++i) {
      entries.first.push_back(i);
      entries.second.push_back(j);
    }
  fill_matrix(entries, segment);
  fill_stream(entries, segment);
  return segment;
}

template SegmentCoefficients<float> make_segment_coefficients(const LaneCoefficients<float>&,
                                                              std::span<const double>,
                                                              std::span<const double>);
template SegmentCoefficients<double> make_segment_coefficients(const LaneCoefficients<double>&,
                                                               std::span<const double>,
                                                               std::span<const double>);

template <>
void evaluate_segment(const SegmentCoefficients<float>& coefficients, const float* middle,
                      const float* half, float* scratch, float* mean, float* tangent,
                      InstructionSet vectors) {
  const SegmentTask<float> task{
      coefficients.modes, coefficients.matrix.data(), middle, half, scratch, mean, tangent};
  TREMOLO_CALL_FOR(vectors, segment_of_floats, task);
}
template <>
void evaluate_segment(const SegmentCoefficients<double>& coefficients, const double* middle,
                      const double* half, double* scratch, double* mean, double* tangent,
                      InstructionSet vectors) {
  const SegmentTask<double> task{
      coefficients.modes, coefficients.matrix.data(), middle, half, scratch, mean, tangent};
  TREMOLO_CALL_FOR(vectors, segment_of_doubles, task);
}
template <>
void evaluate_mean(const SegmentCoefficients<float>& coefficients, const float* middle,
                   const float* half, float* scratch, float* mean, InstructionSet vectors) {
  const SegmentTask<float> task{
      coefficients.modes, coefficients.stream.data(), middle, half, scratch, mean, nullptr};
  TREMOLO_CALL_FOR(vectors, mean_of_floats, task);
}
template <>
void evaluate_mean(const SegmentCoefficients<double>& coefficients, const double* middle,
                   const double* half, double* scratch, double* mean, InstructionSet vectors) {
  const SegmentTask<double> task{
      coefficients.modes, coefficients.stream.data(), middle, half, scratch, mean, nullptr};
  TREMOLO_CALL_FOR(vectors, mean_of_doubles, task);
}

}  // namespace tremolo
