// A model without what only its maker and its reference need.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// The same body with the vertices of the boundary alone, numbered anew in their order: dynamics,
// surface and what is drawn are the same, vertices inside, edges, tetrahedra and imported files are
// gone. The load keeps its vertices on the boundary. kContent if none of a load's vertices is there.
Result<BasisData> without_interior(BasisData data);

}  // namespace tremolo
