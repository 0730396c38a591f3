// What a file keeps of the mesh besides the model.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// What the file keeps of the mesh: surface, interior, triangles, counts, fixed vertices and load;
// the blocks' rows stay empty.
void add_geometry(const Problem& problem, BasisData& data);

}  // namespace tremolo
