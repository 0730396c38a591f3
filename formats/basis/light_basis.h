// A model without the data that only its maker and the reference need.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Returns the same body with only the vertices of the boundary, renumbered in their order.
// Dynamics, surface and drawn surface stay the same; inner vertices, edges, tetrahedra, imported
// files, a load that acts inside and the responses at inner points are removed. kContent if the
// render surface follows an inner vertex.
Result<BasisData> without_interior(BasisData data);

}  // namespace tremolo
