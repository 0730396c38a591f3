// The mesh data that a basis file stores besides the model.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Adds surface, interior, triangles, counts, fixed vertices and load to `data`; the rows of the
// vertex blocks stay empty.
void add_geometry(const Problem& problem, BasisData& data);

}  // namespace tremolo
