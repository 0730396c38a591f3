// The model of the same body made of a stiffer or denser material, without a new precompute.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Factors of Young's modulus and of the density, everywhere in the body; Poisson's ratio stays.
// With M' = d M and V' = s V the same functions of the displacement u:
//   U' = U / sqrt(d), Lambda' = (s/d) Lambda, C' = s d^-3/2 C, Q' = s d^-2 Q,
// so that q' = sqrt(d) q for the same u: exact. Forces of the default load stay. Imported files are
// left out, since their numbers are those of the old material.
// Errors (kContent): a factor that is not positive and finite, numbers that overflow.
Result<BasisData> rescaled(BasisData data, double stiffness, double density);

}  // namespace tremolo
