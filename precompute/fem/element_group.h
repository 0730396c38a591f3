// Element loops on eight elements at a time (SIMD), for the parts of the precompute that dominate
// its time.
#pragma once

#include <vector>

#include "formats/basis/basis_data.h"
#include "precompute/dense/lanes.h"
#include "precompute/fem/stvk.h"

namespace tremolo {

// Computes the displacement gradients of each of `fields` (3n x count, one displacement a column)
// in at most eight elements; unused lanes are zero. out: one entry a field.
void load_gradients(const Solid& solid, const BasisRows& fields, const int* elements,
                    std::size_t count, std::vector<LaneGradient>& out);

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
