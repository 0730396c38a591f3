// Element loops on eight elements at a time (SIMD), for the parts of the precompute that dominate
// its time.
#pragma once

#include <vector>

#include "formats/basis/basis_data.h"
#include "precompute/dense/lanes.h"
#include "precompute/fem/stvk.h"

namespace tremolo {

// The number of coefficients of a displacement gradient (element.h).
constexpr std::size_t gradients_of_order(int order) {
  return order == 1 ? 1 : 4;
}

// Computes the displacement gradients of each of `fields` (3n x count, one displacement a column)
// in at most eight elements; unused lanes are zero. out: gradients_of_order() coefficients a field.
void load_gradients(const Solid& solid, const BasisRows& fields, const int* elements,
                    std::size_t count, std::vector<LaneGradient>& out);

// Computes the gradient at a sample point from its coefficients; out: 9.
template <int kOrder>
[[gnu::always_inline]] inline void gradient_at(const LaneGradient* coefficients,
                                               const SamplePoint& point, Lanes* out) {
  for (int c = 0; c < 9; ++c) {
    out[c] = coefficients[0].at[c];
    if constexpr (kOrder > 1) {
      out[c] *= point.lambda[0];
      for (int a = 1; a < 4; ++a) out[c] += point.lambda[a] * coefficients[a].at[c];
    }
  }
}

// The two columns of `fields` that a second derivative belongs to.
struct ColumnPair {
  int i = 0;
  int j = 0;
};

// Adds -H[fields_i, fields_j] (see add_second_derivative) of each pair to its column of `out`.
// Columns are `stride` apart; rows are those of row_of_vertex.
void subtract_second_derivatives(const Solid& solid, const std::vector<int>& elements,
                                 const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                 const std::vector<int>& row_of_vertex, double* out,
                                 std::size_t stride);

}  // namespace tremolo
