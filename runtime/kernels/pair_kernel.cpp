#include "runtime/kernels/pair_kernel.h"

#include <algorithm>

#include "common/packed_index.h"
#include "runtime/kernels/lanes.h"

#define TREMOLO_KERNEL "runtime/kernels/pair_kernel.inc"
#include "runtime/kernels/every_machine.inc"

namespace tremolo {

using lanes::kLanes;
using plain::block_start;
using plain::kBlock;
using std::size_t;

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
  (*TREMOLO_BEST(fill))(q, r_, padded_, pairs);
}

void PairKernel::fill_pairs(const double* q, const double* more, double s2, double* pairs) const {
  (*TREMOLO_BEST(fill_two))(q, more, s2, r_, padded_, pairs);
}

void PairKernel::multiply(const double* x, size_t first, double* a) const {
  (*TREMOLO_BEST(multiply_columns))(columns_.data(), first / kLanes, padded_ / kLanes, x, a);
}

void PairKernel::multiply_leading(const double* x, size_t first, double* a) const {
  (*TREMOLO_BEST(multiply_rows))(columns_.data(), (first + kLanes - 1) / kLanes, first / kLanes,
                                 padded_ / kLanes, x, a);
}

void PairKernel::contract_cubic(const double* q, size_t k_first, size_t k_end, size_t first,
                                double* b) const {
  (*TREMOLO_BEST(add_cubic))(cubic_.data(), r_, first / kLanes, padded_ / kLanes, k_first, k_end, q,
                             b);
}

void PairKernel::contract_cubic_twice(const double* q, const double* s, double* bq,
                                      double* bs) const {
  (*TREMOLO_BEST(both_cubic))(cubic_.data(), r_, padded_ / kLanes, q, s, bq, bs);
}

}  // namespace tremolo
