#include "runtime/contraction.h"

#include "runtime/clones.h"

namespace tremolo {
namespace {

constexpr std::size_t column(std::size_t b) {
  return b * (b + 1) / 2;
}

}  // namespace

TREMOLO_CLONES
void multiply_symmetric_block(const double* __restrict packed, std::size_t first, std::size_t end,
                              const double* __restrict x, double* __restrict y) {
  std::size_t b = first;
  // Four columns at a time: x and y are then read and written once for four coefficients.
  for (; b + 4 <= end; b += 4) {
    const double* s0 = packed + column(b);
    const double* s1 = packed + column(b + 1);
    const double* s2 = packed + column(b + 2);
    const double* s3 = packed + column(b + 3);
    const double x0 = x[b], x1 = x[b + 1], x2 = x[b + 2], x3 = x[b + 3];
    double d0 = 0.0, d1 = 0.0, d2 = 0.0, d3 = 0.0;
#pragma omp simd reduction(+ : d0, d1, d2, d3)
    for (std::size_t a = first; a < b; ++a) {
      d0 += s0[a] * x[a];
      d1 += s1[a] * x[a];
      d2 += s2[a] * x[a];
      d3 += s3[a] * x[a];
      y[a] += (s0[a] * x0 + s1[a] * x1) + (s2[a] * x2 + s3[a] * x3);
    }
    y[b] += d0 + s0[b] * x0 + s1[b] * x1 + s2[b] * x2 + s3[b] * x3;
    y[b + 1] += d1 + s1[b] * x0 + s1[b + 1] * x1 + s2[b + 1] * x2 + s3[b + 1] * x3;
    y[b + 2] += d2 + s2[b] * x0 + s2[b + 1] * x1 + s2[b + 2] * x2 + s3[b + 2] * x3;
    y[b + 3] += d3 + s3[b] * x0 + s3[b + 1] * x1 + s3[b + 2] * x2 + s3[b + 3] * x3;
  }
  for (; b < end; ++b) {
    const double* s = packed + column(b);
    const double xb = x[b];
    double d = s[b] * xb;
#pragma omp simd reduction(+ : d)
    for (std::size_t a = first; a < b; ++a) {
      d += s[a] * x[a];
      y[a] += s[a] * xb;
    }
    y[b] += d;
  }
}

TREMOLO_CLONES
void multiply_leading_columns(const double* __restrict packed, std::size_t first, std::size_t end,
                              const double* __restrict x, double* __restrict y) {
  for (std::size_t b = first; b < end; ++b) {
    const double* s = packed + column(b);
    double d = 0.0;
#pragma omp simd reduction(+ : d)
    for (std::size_t a = 0; a < first; ++a) d += s[a] * x[a];
    y[b] += d;
  }
}

TREMOLO_CLONES
void add_scaled_rows(const double* __restrict rows, std::size_t stride, std::size_t first,
                     std::size_t end, std::size_t k_first, std::size_t k_end,
                     const double* __restrict x, double* __restrict y) {
  std::size_t k = k_first;
  for (; k + 4 <= k_end; k += 4) {
    const double* r0 = rows + k * stride;
    const double* r1 = r0 + stride;
    const double* r2 = r1 + stride;
    const double* r3 = r2 + stride;
    const double x0 = x[k], x1 = x[k + 1], x2 = x[k + 2], x3 = x[k + 3];
#pragma omp simd
    for (std::size_t a = first; a < end; ++a)
      y[a] += (r0[a] * x0 + r1[a] * x1) + (r2[a] * x2 + r3[a] * x3);
  }
  for (; k < k_end; ++k) {
    const double* row = rows + k * stride;
    const double xk = x[k];
#pragma omp simd
    for (std::size_t a = first; a < end; ++a) y[a] += row[a] * xk;
  }
}

}  // namespace tremolo
