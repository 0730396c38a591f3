// The commands of tremolo-precompute that begin with a solid.
#pragma once

#include "precompute/options/options.h"
#include "precompute/problem/precompute_request.h"

namespace tremolo {

// Top-level commands of tremolo-precompute. Prints a selection, writes a preview, imports a basis
// or computes one, and writes the outputs; results and JSON go to stdout, progress to stderr. Needs
// a PetscSession. Throws Failure.
void run_command(const CommandLine& line);

// The main path of tremolo-precompute: from a request to a basis file. Computes a basis and writes
// the outputs; JSON goes to stdout, progress to stderr. Needs a PetscSession. Throws Failure.
// Collective.
void compute(const PrecomputeRequest& request);

}  // namespace tremolo
