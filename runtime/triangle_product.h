// y = (T + T^T) q for a packed upper triangle T in the order of pair_index: the last stage of both
// kernels of the potential. For use inside functions marked TREMOLO_CLONES.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "common/packed_index.h"
#include "runtime/aligned.h"
#include "runtime/lanes.h"

namespace tremolo {

// Row m, eight long: all bits set in the first m lanes, m = 0..8. From memory, since the compiler
// would turn known masks into loads of single lanes.
inline AlignedDoubles lane_masks() {
  AlignedDoubles masks((lanes::kLanes + 1) * lanes::kLanes, 0.0);
  for (std::size_t row = 0; row <= lanes::kLanes; ++row)
    for (std::size_t lane = 0; lane < row; ++lane)
      masks[row * lanes::kLanes + lane] = std::bit_cast<double>(~std::uint64_t{0});
  return masks;
}

// One column of the packed triangle T, the `lane`-th of its group of eight: adds T_ij q_j to y and
// returns the parts of sum_i T_ij q_i. mask keeps the first lane + 1.
template <int Chunk>
TREMOLO_INLINE lanes::Vector add_column(const double* column, const double* q, lanes::Vector mask,
                                        double qj, lanes::Vector* y) {
  const lanes::Vector factor = lanes::all(qj);
  lanes::Vector sum{};
#pragma GCC unroll 4
  for (int c = 0; c < Chunk; ++c) {
    const lanes::Vector t =
        lanes::load_loose_once(column + static_cast<std::size_t>(c) * lanes::kLanes);
    sum += t * lanes::load(q + static_cast<std::size_t>(c) * lanes::kLanes);
    y[c] += t * factor;
  }
  const lanes::Vector t = lanes::both(lanes::load_loose(column + Chunk * lanes::kLanes), mask);
  sum += t * lanes::load(q + Chunk * lanes::kLanes);
  y[Chunk] += t * factor;
  return sum;
}

// Adds (T + T^T) q for the columns [8 Chunk, 8 Chunk + 8).
template <int Chunk>
TREMOLO_INLINE void add_column_group(const double* triangle, const double* q, const double* masks,
                                     lanes::Vector* y) {
  constexpr std::size_t kFirst = Chunk * lanes::kLanes;
  const double* column = triangle + pair_count(kFirst);
  lanes::Vector sums[lanes::kLanes];
#pragma GCC unroll 8
  for (std::size_t lane = 0; lane < lanes::kLanes; ++lane) {
    sums[lane] = add_column<Chunk>(column, q, lanes::load(masks + (lane + 1) * lanes::kLanes),
                                   q[kFirst + lane], y);
    column += kFirst + lane + 1;
  }
  y[Chunk] += lanes::sums(sums);
}

// y = (T + T^T) q, T packed, n columns, zeros up to the next multiple of eight. q, y: padded(n).
TREMOLO_INLINE void triangle_product(const double* triangle, std::size_t n, const double* q,
                                     const double* masks, double* y) {
  lanes::Vector part[4] = {};
  add_column_group<0>(triangle, q, masks, part);
  if (n > 8) add_column_group<1>(triangle, q, masks, part);
  if (n > 16) add_column_group<2>(triangle, q, masks, part);
  if (n > 24) add_column_group<3>(triangle, q, masks, part);
  for (std::size_t c = 0; c < 4 && c * lanes::kLanes < n; ++c)
    lanes::store(y + c * lanes::kLanes, part[c]);
  for (std::size_t i = 32; i < n; i += lanes::kLanes) lanes::store(y + i, lanes::Vector{});
  for (std::size_t j = 32; j < n; ++j) {
    const double* column = triangle + pair_count(j);
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (std::size_t i = 0; i < j; ++i) {
      sum += column[i] * q[i];
      y[i] += column[i] * q[j];
    }
    y[j] += sum + 2.0 * column[j] * q[j];
  }
}

}  // namespace tremolo
