// Error of a compact file: the computed model against the one that a reader returns.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Lengths are relative to the diagonal of the solid's bounding box. Motions reach a tenth of it,
// the largest that Tremolo is meant for.
//
// displacement: largest |U_c q - U q| over all vertices for q = Lambda^-1 U^T f, the linear
// response to the default load, scaled so that some vertex moves by a tenth; without a default
// load, for the first coordinate.
// displacement_bound: the same for any q of which no coordinate alone moves a vertex by more than a
// tenth: largest sum of |U_c,i - U_i| |q_i|.
// force: |grad V_c - grad V| / |Lambda q| at the q of `displacement`: error of the internal force
// relative to the load.
struct EncodingError {
  double displacement = 0.0;
  double displacement_bound = 0.0;
  double force = 0.0;
};

// kept: the model read from the file that `full` was written to.
EncodingError encoding_error(const BasisData& full, const BasisData& kept);

// Returns the error of writing `full` compactly; kContent if it cannot be encoded.
Result<EncodingError> compact_error(const BasisData& full);

}  // namespace tremolo
