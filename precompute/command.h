// Top-level commands of tremolo-precompute.
#pragma once

#include "precompute/options/options.h"

namespace tremolo {

// Prints a selection, writes a preview, imports a basis or computes one, and writes the outputs;
// results and JSON go to stdout, progress to stderr. Needs a PetscSession. Throws Failure.
void run_command(const CommandLine& line);

}  // namespace tremolo
