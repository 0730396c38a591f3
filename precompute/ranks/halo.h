// What the ranks tell each other about vertices at the seams of their parts.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/fem/dof_map.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// Values of each rank's own rows -> values at all vertices of its part of the mesh: 3 rows a vertex
// x columns, zero where a vertex is fixed. What belongs to other ranks' nodes comes from them. All
// ranks call it together.
BasisRows expand_to_vertices(const DofMap& map, const LocalDofs& local, const Columns& columns);

// A mode's sign is a convention: the first entry, in the mesh's vertex order, that is at least half
// of the largest becomes positive. Half, so that rounding cannot decide between mirror images.
// vectors: local rows; expanded: the same at the part's vertices. Both are changed.
void fix_signs(const LocalDofs& local, Columns& vectors, BasisRows& expanded);

}  // namespace tremolo
