#include "runtime/symmetric_kernel.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"
#include "runtime/clones.h"
#include "runtime/lanes.h"
#include "runtime/triangle_product.h"

namespace tremolo {
namespace {

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::load_loose;
using lanes::padded;
using lanes::store;
using lanes::Vector;
using std::size_t;

constexpr size_t padded_pairs(size_t k) {
  return padded(pair_count(k + 1));
}

// The rows in the order in which they lie: blocks of four l (the first of them shorter if need be),
// in each all k from the block's last l down to 0, two at a time once they are below the block. Z^l
// of a block stays in the level-1 cache while Z^k passes through.
// visit.one(k, l, count): rows (k, l) to (k, l + count - 1), interleaved by vectors.
// visit.two(k, l): rows (k, l) to (k, l + 3) and (k - 1, l) to (k - 1, l + 3), the latter padded to
// the length of the former.
template <class Visitor>
TREMOLO_INLINE void for_each_group(size_t r, Visitor& visit) {
  size_t begin = 0;
  for (size_t end = r % 4 + 1; end <= r + 1; begin = end, end += 4) {
    size_t k = end <= r ? end : r;
    for (; k > begin; --k) visit.one(k - 1, k - 1, end - (k - 1));
    for (; k > 1; k -= 2) visit.two(k - 1, begin);
    if (k == 1) visit.one(0, begin, end - begin);
  }
}

// x and the point with its constant coordinate; what lies behind stays zero.
TREMOLO_INLINE void fill_point(const double* q, size_t r, double* point, double* pairs) {
  for (size_t i = 0; i < r; ++i) point[i] = q[i];
  point[r] = 1.0;
  // Column j begins anywhere; what a store leaves behind its end the next one overwrites.
  for (size_t j = 0; j < r; ++j) {
    const Vector factor = all(q[j]);
    for (size_t i = 0; i <= j; i += kLanes)
      lanes::store_loose(pairs + pair_count(j) + i, factor * load(point + i));
  }
  for (size_t at = pair_count(r); at < padded(pair_count(r)); ++at) pairs[at] = 0.0;
}

// W of `count` rows from l on.
TREMOLO_INLINE void put_sums(Vector sums, size_t count, size_t k, size_t l, size_t r, double* w,
                             double* last) {
  for (size_t b = 0; b < count; ++b) {
    if (l + b < r)
      w[pair_count(l + b) + k] = sums[b];
    else
      last[k] = sums[b];
  }
}

// W of the eight rows of two(k, l).
TREMOLO_INLINE void put_pair_sums(Vector sums, size_t k, size_t l, size_t r, double* w,
                                  double* last) {
#pragma GCC unroll 4
  for (size_t b = 0; b < 4; ++b) {
    double* at = l + b < r ? w + pair_count(l + b) + k : last + k;
    at[0] = sums[b];
    at[-1] = sums[4 + b];
  }
}

// ---- gradient: W and E ----

template <int Rows>
TREMOLO_INLINE Vector add_gradient_rows(const double* rows, size_t length, double qk,
                                        const double* ql, const double* pairs, double* e) {
  Vector sums[4] = {};
  Vector weights[Rows] = {};
#pragma GCC unroll 4
  for (int b = 0; b < Rows; ++b) weights[b] = all(qk * ql[b]);
  for (size_t t = 0; t < length; t += kLanes) {
    const Vector x = load(pairs + t);
    Vector sum = load(e + t);
#pragma GCC unroll 4
    for (int b = 0; b < Rows; ++b, rows += kLanes) {
      const Vector c = lanes::load_once(rows);
      sums[b] += c * x;
      sum += c * weights[b];
    }
    store(e + t, sum);
  }
  return lanes::sums(sums[0], sums[1], sums[2], sums[3]);
}

TREMOLO_INLINE Vector add_gradient_pair(const double* rows, size_t length, double qk, double qk1,
                                        const double* ql, const double* pairs, double* e) {
  Vector sums[8] = {};
  Vector weights[8] = {};
#pragma GCC unroll 4
  for (int b = 0; b < 4; ++b) {
    weights[b] = all(qk * ql[b]);
    weights[4 + b] = all(qk1 * ql[b]);
  }
  for (size_t t = 0; t < length; t += kLanes) {
    const Vector x = load(pairs + t);
    Vector one = load(e + t), two{};
#pragma GCC unroll 4
    for (int b = 0; b < 4; ++b, rows += kLanes) {
      const Vector c = lanes::load_once(rows);
      sums[b] += c * x;
      one += c * weights[b];
      const Vector d = lanes::load_once(rows + 4 * kLanes);
      sums[4 + b] += d * x;
      two += d * weights[4 + b];
    }
    rows += 4 * kLanes;
    store(e + t, one + two);
  }
  return lanes::sums(sums);
}

struct GradientSums {
  const double* rows;
  size_t r;
  const double* point;
  const double* pairs;
  double* e;
  double* w;
  double* last;

  TREMOLO_INLINE void one(size_t k, size_t l, size_t count) {
    const size_t length = padded_pairs(k);
    const double qk = point[k];
    const double* ql = point + l;
    Vector sums;
    if (count == 4)
      sums = add_gradient_rows<4>(rows, length, qk, ql, pairs, e);
    else if (count == 3)
      sums = add_gradient_rows<3>(rows, length, qk, ql, pairs, e);
    else if (count == 2)
      sums = add_gradient_rows<2>(rows, length, qk, ql, pairs, e);
    else
      sums = add_gradient_rows<1>(rows, length, qk, ql, pairs, e);
    put_sums(sums, count, k, l, r, w, last);
    rows += count * length;
  }

  TREMOLO_INLINE void two(size_t k, size_t l) {
    const size_t length = padded_pairs(k);
    put_pair_sums(add_gradient_pair(rows, length, point[k], point[k - 1], point + l, pairs, e), k,
                  l, r, w, last);
    rows += 8 * length;
  }
};

TREMOLO_CLONES void gradient_sums(const double* rows, size_t r, const double* point,
                                  const double* pairs, double* e, double* w, double* last) {
  for (size_t t = 0; t < padded_pairs(r - 1); t += kLanes) store(e + t, Vector{});
  GradientSums sums{rows, r, point, pairs, e, w, last};
  for_each_group(r, sums);
}

// F = E + W, P = E . x.
TREMOLO_INLINE double fold_pair_parts(const double* pairs, const double* w, size_t count,
                                      double* e) {
  Vector value{};
  for (size_t t = 0; t < count; t += kLanes) {
    const Vector part = load(e + t);
    value += part * load(pairs + t);
    store(e + t, part + load(w + t));
  }
  return lanes::sum(value);
}

TREMOLO_CLONES double evaluate_gradient(const double* rows, size_t r, const double* q,
                                        double* point, double* pairs, double* e, double* w,
                                        double* last, const double* masks, double* y,
                                        double* gradient) {
  fill_point(q, r, point, pairs);
  gradient_sums(rows, r, point, pairs, e, w, last);
  const double value = fold_pair_parts(pairs, w, padded_pairs(r - 1), e);
  triangle_product(e, r, point, masks, y);
  for (size_t i = 0; i < r; ++i) gradient[i] = y[i] + last[i];
  return value;
}

// ---- Hessian: W and Z ----

// Rows (k, l) to (k, l + Rows - 1); the first of a First block is l = k. own: Z^k, written by the
// first block. others: Z^l, `stride` apart; there from a larger k already.
template <int Rows, bool First>
TREMOLO_INLINE Vector add_hessian_rows(const double* __restrict rows, size_t length,
                                       const double* __restrict ql, Vector qk,
                                       const double* __restrict pairs, double* own, double* others,
                                       size_t stride) {
  Vector sums[4] = {};
  Vector weights[Rows] = {};
#pragma GCC unroll 4
  for (int b = 0; b < Rows; ++b) weights[b] = all(First && b == 0 ? 2.0 * ql[b] : ql[b]);
  for (size_t t = 0; t < length; t += kLanes) {
    const Vector x = load(pairs + t);
    Vector sum = First ? Vector{} : load(own + t);
#pragma GCC unroll 4
    for (int b = 0; b < Rows; ++b, rows += kLanes) {
      const Vector c = lanes::load_once(rows);
      sums[b] += c * x;
      sum += c * weights[b];
      if (First && b == 0) continue;
      double* other = others + static_cast<size_t>(b) * stride + t;
      store(other, load(other) + c * qk);
    }
    store(own + t, sum);
  }
  return lanes::sums(sums[0], sums[1], sums[2], sums[3]);
}

// Rows (k, l) to (k, l + 3) and (k - 1, l) to (k - 1, l + 3), k < l. own: Z^k; own1: Z^(k-1).
TREMOLO_INLINE Vector add_hessian_pair(const double* rows, size_t length, const double* ql,
                                       Vector qk, Vector qk1, const double* pairs, double* own,
                                       double* own1, double* others, size_t stride) {
  Vector sums[8] = {};
  Vector weights[4] = {};
#pragma GCC unroll 4
  for (int b = 0; b < 4; ++b) weights[b] = all(ql[b]);
  for (size_t t = 0; t < length; t += kLanes) {
    const Vector x = load(pairs + t);
    Vector one = load(own + t), two = load(own1 + t);
#pragma GCC unroll 4
    for (int b = 0; b < 4; ++b, rows += kLanes) {
      const Vector c = lanes::load_once(rows);
      const Vector d = lanes::load_once(rows + 4 * kLanes);
      sums[b] += c * x;
      sums[4 + b] += d * x;
      one += c * weights[b];
      two += d * weights[b];
      double* other = others + static_cast<size_t>(b) * stride + t;
      store(other, (load(other) + c * qk) + d * qk1);
    }
    rows += 4 * kLanes;
    store(own + t, one);
    store(own1 + t, two);
  }
  return lanes::sums(sums);
}

template <bool First>
TREMOLO_INLINE Vector add_some_hessian_rows(size_t count, const double* rows, size_t length,
                                            const double* ql, Vector qk, const double* pairs,
                                            double* own, double* others, size_t stride) {
  switch (count) {
    case 1:
      return add_hessian_rows<1, First>(rows, length, ql, qk, pairs, own, others, stride);
    case 2:
      return add_hessian_rows<2, First>(rows, length, ql, qk, pairs, own, others, stride);
    case 3:
      return add_hessian_rows<3, First>(rows, length, ql, qk, pairs, own, others, stride);
    default:
      return add_hessian_rows<4, First>(rows, length, ql, qk, pairs, own, others, stride);
  }
}

struct HessianSums {
  const double* rows;
  size_t r;
  size_t stride;
  const double* point;
  const double* pairs;
  double* z;
  double* w;
  double* last;

  TREMOLO_INLINE void one(size_t k, size_t l, size_t count) {
    const size_t length = padded_pairs(k);
    const Vector qk = all(point[k]);
    double* own = z + k * stride;
    double* others = z + l * stride;
    const Vector sums = k == l ? add_some_hessian_rows<true>(count, rows, length, point + l, qk,
                                                             pairs, own, others, stride)
                               : add_some_hessian_rows<false>(count, rows, length, point + l, qk,
                                                              pairs, own, others, stride);
    put_sums(sums, count, k, l, r, w, last);
    rows += count * length;
  }

  TREMOLO_INLINE void two(size_t k, size_t l) {
    const size_t length = padded_pairs(k);
    put_pair_sums(add_hessian_pair(rows, length, point + l, all(point[k]), all(point[k - 1]), pairs,
                                   z + k * stride, z + (k - 1) * stride, z + l * stride, stride),
                  k, l, r, w, last);
    rows += 8 * length;
  }
};

// W and all Z.
TREMOLO_CLONES void hessian_sums(const double* rows, size_t r, size_t stride, const double* point,
                                 const double* pairs, double* z, double* w, double* last) {
  for (size_t t = 0; t < padded_pairs(r - 1); t += kLanes) store(z + r * stride + t, Vector{});
  HessianSums sums{rows, r, stride, point, pairs, z, w, last};
  for_each_group(r, sums);
}

// 2E = sum_k q_k Z^k + Z^r.
TREMOLO_INLINE void fold_thirds(const double* z, size_t r, size_t stride, const double* point,
                                double* e) {
  for (size_t t = 0; t < padded_pairs(r - 1); t += kLanes) {
    Vector sum = load(z + r * stride + t);
    for (size_t k = r; k-- > 0 && padded_pairs(k) > t;)
      sum += load(z + k * stride + t) * all(point[k]);
    store(e + t, sum * all(0.5));
  }
}

TREMOLO_CLONES double evaluate_hessian(const double* rows, size_t r, size_t stride, const double* q,
                                       double* point, double* pairs, double* e, double* w,
                                       double* last, double* z, const double* masks, double* y,
                                       double* gradient, double* hessian) {
  fill_point(q, r, point, pairs);
  hessian_sums(rows, r, stride, point, pairs, z, w, last);
  fold_thirds(z, r, stride, point, e);
  const double value = fold_pair_parts(pairs, w, padded_pairs(r - 1), e);
  triangle_product(e, r, point, masks, y);
  for (size_t i = 0; i < r; ++i) gradient[i] = y[i] + last[i];
  for (size_t k = 0; k < r; ++k) {
    triangle_product(z + k * stride, k + 1, point, masks, y);
    const double* f = e + pair_count(k);
    double* column = hessian + k * r;
    // What goes beyond row k, into the next column too, is written again below.
    if (r >= kLanes && k + 1 < r)
      for (size_t j = 0; j <= k; j += kLanes)
        lanes::store_loose(column + j, load_loose(f + j) + load(y + j));
    else
      for (size_t j = 0; j <= k; ++j) column[j] = f[j] + y[j];
  }
  for (size_t k = 0; k < r; ++k) hessian[k * r + k] *= 2.0;
  for (size_t k = 0; k < r; ++k)
    for (size_t j = 0; j < k; ++j) hessian[j * r + k] = hessian[k * r + j];
  return value;
}

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
  return evaluate_gradient(rows_.data(), r_, q, w.point.data(), w.pairs.data(), w.folded.data(),
                           w.sums.data(), w.last.data(), masks_.data(), w.column.data(), gradient);
}

double SymmetricKernel::hessian(const double* q, Workspace& w, double* gradient,
                                double* hessian) const {
  const double value = evaluate_hessian(
      rows_.data(), r_, stride_, q, w.point.data(), w.pairs.data(), w.folded.data(), w.sums.data(),
      w.last.data(), w.thirds.data(), masks_.data(), w.column.data(), gradient, hessian);
  // What lies behind each Z^k must stay zero.
  if (!std::isfinite(value)) std::fill(w.thirds.begin(), w.thirds.end(), 0.0);
  return value;
}

}  // namespace tremolo
