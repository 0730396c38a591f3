// The mesh data that a basis file stores besides the model.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// A quadratic body's boundary of fewer triangles is drawn with its edge points, four triangles for
// each, unless the user says otherwise.
inline constexpr std::size_t kCoarseBoundary = 5'000;

// Adds surface, interior, triangles, counts, fixed vertices and load to `data`; the rows of the
// vertex blocks stay empty.
void add_geometry(const Problem& problem, BasisData& data);

// Adds the tetrahedra and their masses, kg.
void add_elements(const Problem& problem, BasisData& data);

}  // namespace tremolo
