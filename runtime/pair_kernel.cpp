#include "runtime/pair_kernel.h"

#include <algorithm>

#include "common/packed_index.h"
#include "runtime/clones.h"
#include "runtime/lanes.h"

namespace tremolo {
namespace {

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::load_once;
using lanes::store;
using lanes::Vector;
using std::size_t;

constexpr size_t kBlock = kLanes * kLanes;  // eight rows of eight columns

// Where the columns [8 group, 8 group + 8) begin.
constexpr size_t block_start(size_t group) {
  return group * (group + 1) / 2 * kBlock;
}

// S x on the rows and columns from `start` on, both counted in vectors.
TREMOLO_CLONES void multiply_columns(const double* columns, size_t start, size_t groups,
                                     const double* x, double* y) {
  for (size_t group = start; group < groups; ++group) {
    const double* c = columns + block_start(group) + start * kBlock;
    Vector sums[kLanes] = {};
    Vector weights[kLanes] = {};
#pragma GCC unroll 8
    for (size_t b = 0; b < kLanes; ++b) weights[b] = all(x[group * kLanes + b]);
    for (size_t t = start * kLanes; t <= group * kLanes; t += kLanes) {
      const Vector row = load(x + t);
      Vector one = load(y + t), two{};
#pragma GCC unroll 4
      for (size_t b = 0; b < kLanes; b += 2, c += 2 * kLanes) {
        const Vector even = load_once(c);
        sums[b] += even * row;
        one += even * weights[b];
        const Vector odd = load_once(c + kLanes);
        sums[b + 1] += odd * row;
        two += odd * weights[b + 1];
      }
      store(y + t, one + two);
    }
    double* end = y + group * kLanes;
    store(end, load(end) + lanes::sums(sums));
  }
}

// The same for rows below `rows` vectors and columns from `start` on, columns' sums alone.
TREMOLO_CLONES void multiply_rows(const double* columns, size_t rows, size_t start, size_t groups,
                                  const double* x, double* y) {
  for (size_t group = start; group < groups; ++group) {
    const double* c = columns + block_start(group);
    const size_t end = group + 1 < rows ? group + 1 : rows;
    Vector sums[kLanes] = {};
    for (size_t t = 0; t < end; ++t) {
      const Vector row = load(x + t * kLanes);
#pragma GCC unroll 8
      for (size_t b = 0; b < kLanes; ++b, c += kLanes) sums[b] += load(c) * row;
    }
    store(y + group * kLanes, lanes::sums(sums));
  }
}

TREMOLO_CLONES void add_cubic(const double* cubic, size_t r, size_t start, size_t groups,
                              size_t k_first, size_t k_end, const double* q, double* b) {
  for (size_t t = start; t < groups; ++t) {
    const double* c = cubic + t * r * kLanes;
    Vector even = load(b + t * kLanes), odd{};
    size_t k = k_first;
    for (; k + 2 <= k_end; k += 2) {
      even += load(c + k * kLanes) * all(q[k]);
      odd += load(c + (k + 1) * kLanes) * all(q[k + 1]);
    }
    if (k < k_end) even += load(c + k * kLanes) * all(q[k]);
    store(b + t * kLanes, even + odd);
  }
}

TREMOLO_CLONES void both_cubic(const double* cubic, size_t r, size_t groups, const double* q,
                               const double* s, double* bq, double* bs) {
  for (size_t t = 0; t < groups; ++t, cubic += r * kLanes) {
    Vector first{}, second{};
    for (size_t k = 0; k < r; ++k) {
      const Vector c = load_once(cubic + k * kLanes);
      first += c * all(q[k]);
      second += c * all(s[k]);
    }
    store(bq + t * kLanes, first);
    store(bs + t * kLanes, second);
  }
}

TREMOLO_CLONES void fill(const double* q, size_t r, size_t padded, double* pairs) {
  double* x = pairs;
  for (size_t j = 0; j < r; ++j) {
    const double twice = 2.0 * q[j];
    for (size_t i = 0; i < j; ++i) x[i] = twice * q[i];
    x[j] = q[j] * q[j];
    x += j + 1;
  }
  std::fill(x, pairs + padded, 0.0);
}

TREMOLO_CLONES void fill_two(const double* q, const double* s, double s2, size_t r, size_t padded,
                             double* pairs) {
  double* x = pairs;
  for (size_t j = 0; j < r; ++j) {
    const double q2 = 2.0 * q[j], sj = 2.0 * s2 * s[j];
    for (size_t i = 0; i < j; ++i) x[i] = q2 * q[i] + sj * s[i];
    x[j] = 0.5 * (q2 * q[j] + sj * s[j]);
    x += j + 1;
  }
  std::fill(x, pairs + padded, 0.0);
}

}  // namespace

PairKernel::PairKernel(size_t r, std::span<const double> cubic, std::span<const double> quartic)
    : r_(r), padded_(lanes::padded(pair_count(r))) {
  const size_t groups = padded_ / kLanes;
  columns_.assign(block_start(groups), 0.0);
  cubic_.assign(padded_ * r, 0.0);
  for (size_t l = 0; l < r; ++l)
    for (size_t k = 0; k <= l; ++k) {
      const size_t b = pair_index(k, l);
      double* column = columns_.data() + block_start(b / kLanes) + b % kLanes * kLanes;
      for (size_t j = 0; j <= l; ++j)
        for (size_t i = 0; i <= (j < l ? j : k); ++i) {
          const size_t a = pair_index(i, j);
          column[a / kLanes * kBlock + a % kLanes] =
              (a == b ? 0.5 : 1.0) * quartic[quad_index_any(i, j, k, l)];
        }
      for (size_t i = 0; i < r; ++i)
        cubic_[(b / kLanes * r + i) * kLanes + b % kLanes] = cubic[triple_index_any(i, k, l)];
    }
}

void PairKernel::fill_pairs(const double* q, double* pairs) const {
  fill(q, r_, padded_, pairs);
}

void PairKernel::fill_pairs(const double* q, const double* more, double s2, double* pairs) const {
  fill_two(q, more, s2, r_, padded_, pairs);
}

void PairKernel::multiply(const double* x, size_t first, double* a) const {
  multiply_columns(columns_.data(), first / kLanes, padded_ / kLanes, x, a);
}

void PairKernel::multiply_leading(const double* x, size_t first, double* a) const {
  multiply_rows(columns_.data(), (first + kLanes - 1) / kLanes, first / kLanes, padded_ / kLanes, x,
                a);
}

void PairKernel::contract_cubic(const double* q, size_t k_first, size_t k_end, size_t first,
                                double* b) const {
  add_cubic(cubic_.data(), r_, first / kLanes, padded_ / kLanes, k_first, k_end, q, b);
}

void PairKernel::contract_cubic_twice(const double* q, const double* s, double* bq,
                                      double* bs) const {
  both_cubic(cubic_.data(), r_, padded_ / kLanes, q, s, bq, bs);
}

}  // namespace tremolo
