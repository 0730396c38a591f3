// The main path of tremolo-precompute: from a request to a basis file.
#pragma once

#include "precompute/problem/precompute_request.h"

namespace tremolo {

// Computes a basis and writes the outputs; JSON goes to stdout, progress to stderr. Needs a
// PetscSession. Throws Failure. Collective.
void compute(const PrecomputeRequest& request);

}  // namespace tremolo
