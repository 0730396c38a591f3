// Eight elements side by side, for the loops over elements that the precompute spends time in.
#pragma once

#include <vector>

#include "formats/basis/basis_data.h"
#include "precompute/dense/lanes.h"
#include "precompute/fem/stvk.h"

namespace tremolo {

// Displacement gradients of each of `fields` (3n x count, one displacement a column) in at most
// eight elements; lanes left over are zero. out: one a field.
void load_gradients(const Solid& solid, const BasisRows& fields, const int* elements,
                    std::size_t count, std::vector<LaneGradient>& out);

// Which pair of columns a second derivative belongs to.
struct ColumnPair {
  int i = 0;
  int j = 0;
};

// Adds -H[fields_i, fields_j] (add_second_derivative) of each pair to its column of `out`; columns
// are `stride` apart, rows those of row_of_vertex.
void subtract_second_derivatives(const Solid& solid, const std::vector<int>& elements,
                                 const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                 const std::vector<int>& row_of_vertex, double* out,
                                 std::size_t stride);

}  // namespace tremolo
