// What a compact file loses: the model that was computed against the one that is read back.
#pragma once

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Lengths are relative to the diagonal of the solid's bounding box. "A tenth" is a tenth of it: as
// far as Tremolo's motions go.
//
// displacement: largest |U_c q - U q| over all vertices, for the q with which the linear solid
//   answers the default load, Lambda^-1 U^T f, scaled so that it moves some vertex by a tenth;
//   without a default load the first coordinate does.
// displacement_bound: the same for any q of which no coordinate alone moves a vertex by more than a
//   tenth: largest sum of |U_c,i - U_i| |q_i|.
// force: |grad V_c - grad V| / |Lambda q| at the q of `displacement`: an error of the inner force
// in
//   parts of the load.
struct EncodingError {
  double displacement = 0.0;
  double displacement_bound = 0.0;
  double force = 0.0;
};

// kept: what a reader finds in the file that `full` became.
EncodingError encoding_error(const BasisData& full, const BasisData& kept);

// The error of `full` when it is written compactly. kContent if it cannot be.
Result<EncodingError> compact_error(const BasisData& full);

}  // namespace tremolo
