// Models made of a model's data: of its boundary alone, or of another material.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// A model without the data that only its maker and the reference need. Returns the same body with
// only the vertices of the boundary, renumbered in their order. Dynamics, surface and drawn surface
// stay the same; inner vertices, edges, tetrahedra, imported files, a load that acts inside and the
// responses at inner points are removed. kContent if the render surface follows an inner vertex.
Result<BasisData> without_interior(BasisData data);

// The model of the same body made of a stiffer or denser material, without a new precompute.

// Factors of Young's modulus and of the density, everywhere in the body; Poisson's ratio stays.
// With M' = d M and V' = s V the same functions of the displacement u:
//   U' = U / sqrt(d), Lambda' = (s/d) Lambda, C' = s d^-3/2 C, Q' = s d^-2 Q,
// so that q' = sqrt(d) q for the same u: exact. Forces of the default load stay. Imported files are
// left out, since their numbers are those of the old material.
// Errors (kContent): a factor that is not positive and finite, numbers that overflow.
Result<BasisData> rescaled(BasisData data, double stiffness, double density);

}  // namespace tremolo
