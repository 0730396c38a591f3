#include "runtime/math/kernels/pair_kernel.h"

#include <algorithm>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// C_ijk for the pairs i <= j: for each of `groups` vectors of pairs all k, a vector each.
struct CubicRows {
  const double* c;
  std::size_t r;
  std::size_t groups;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/kernels/pair_kernel.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using std::size_t;

PairKernel::PairKernel(size_t r, std::span<const double> cubic, std::span<const double> quartic)
    : r_(r), padded_(padded(pair_count(r))) {
  s_.assign(plain::group_start(padded_ / kVectorLanes), 0.0);
  c_.assign(padded_ * r, 0.0);
  for (size_t l = 0; l < r; ++l)
    for (size_t k = 0; k <= l; ++k) {
      const size_t b = pair_index(k, l);
      const size_t group = b / kVectorLanes, lane = b % kVectorLanes;
      double* column = s_.data() + plain::group_start(group) + lane * kVectorLanes;
      for (size_t j = 0; j <= l; ++j)
        for (size_t i = 0; i <= (j < l ? j : k); ++i) {
          const size_t a = pair_index(i, j);
          column[a / kVectorLanes * plain::kTile + a % kVectorLanes] =
              (a == b ? 0.5 : 1.0) * quartic[quad_index_any(i, j, k, l)];
        }
      for (size_t i = 0; i < r; ++i)
        c_[(group * r + i) * kVectorLanes + lane] = cubic[triple_index_any(i, k, l)];
    }
}

void PairKernel::fill_pairs(const double* q, double* pairs) const {
  TREMOLO_CALL(set_pairs, q, r_, padded_, pairs);
}

void PairKernel::fill_pairs(const double* q, const double* more, double s2, double* pairs) const {
  TREMOLO_CALL(set_pairs_of_two, q, more, s2, r_, padded_, pairs);
}

void PairKernel::multiply(const double* x, size_t first, double* a) const {
  TREMOLO_CALL(multiply_columns, s_.data(), first / kVectorLanes, padded_ / kVectorLanes, x, a);
}

void PairKernel::multiply_leading(const double* x, size_t first, double* a) const {
  const size_t rows = (first + kVectorLanes - 1) / kVectorLanes;
  TREMOLO_CALL(multiply_rows, s_.data(), rows, first / kVectorLanes, padded_ / kVectorLanes, x, a);
}

void PairKernel::contract_cubic(const double* q, size_t k_first, size_t k_end, size_t first,
                                double* b) const {
  const CubicRows cubic{c_.data(), r_, padded_ / kVectorLanes};
  TREMOLO_CALL(add_cubic, cubic, first / kVectorLanes, k_first, k_end, q, b);
}

void PairKernel::contract_cubic_twice(const double* q, const double* s, double* bq,
                                      double* bs) const {
  TREMOLO_CALL(set_two_cubic, {c_.data(), r_, padded_ / kVectorLanes}, q, s, bq, bs);
}

}  // namespace tremolo
