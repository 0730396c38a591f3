// Halo exchange: values at vertices on the interfaces between the ranks' parts.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/fem/dof_map.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// Expands values on this rank's rows to all vertices of its part of the mesh: 3 rows a vertex x
// columns, zero at fixed vertices. Values at other ranks' nodes are received from them. Collective.
BasisRows expand_to_vertices(const DofMap& map, const LocalDofs& local, const Columns& columns);

// Fixes the sign of each mode by convention: the first entry, in the mesh's vertex order, that is
// at least half of the largest becomes positive. Half, so that rounding cannot decide between
// mirror images. vectors: local rows; expanded: the same at the part's vertices. Both are changed.
void fix_signs(const LocalDofs& local, Columns& vectors, BasisRows& expanded);

}  // namespace tremolo
