// `tremolo-precompute tets`: a mesh or a surface becomes a file of tetrahedra for the engine.
#pragma once

#include "precompute/tets/tets_options.h"

namespace tremolo {

// Reads and checks the solid as for a basis, attaches the drawn surface to it, computes the
// distances at rest and writes the file; JSON goes to stdout, progress to stderr. Throws Failure.
void make_tets(const TetsOptions& options);

}  // namespace tremolo
