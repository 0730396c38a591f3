// The two inner loops of the potential: y += S x for a symmetric S that is stored as its packed
// upper triangle, column by column: S_ab (a <= b) at b(b+1)/2 + a (common/packed_index.h).
#pragma once

#include <cstddef>

namespace tremolo {

// y[first..end) += S[first..end, first..end) x[first..end). Each coefficient is loaded once.
void multiply_symmetric_block(const double* packed, std::size_t first, std::size_t end,
                              const double* x, double* y);

// y[first..end) += S[first..end, 0..first) x[0..first).
void multiply_leading_columns(const double* packed, std::size_t first, std::size_t end,
                              const double* x, double* y);

// y[first..end) += sum over k in [k_first, k_end) of x[k] * rows[k * stride + first..end).
void add_scaled_rows(const double* rows, std::size_t stride, std::size_t first, std::size_t end,
                     std::size_t k_first, std::size_t k_end, const double* x, double* y);

}  // namespace tremolo
