// A model without what only its maker and its reference need.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// The same body with the vertices of the boundary alone, numbered anew in their order: dynamics,
// surface and what is drawn are the same; vertices inside, edges, tetrahedra, imported files, a
// load that acts inside and the responses at places inside are gone. kContent where the render
// surface follows a vertex inside.
Result<BasisData> without_interior(BasisData data);

}  // namespace tremolo
