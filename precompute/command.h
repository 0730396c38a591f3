// What tremolo-precompute does with its command line.
#pragma once

#include "precompute/options/options.h"

namespace tremolo {

// Shows a selection, paints a preview, imports a basis or computes one, and writes what was asked
// for; results and JSON go to stdout, progress to stderr. Needs a PetscSession. Throws Failure.
void run_command(const CommandLine& line);

}  // namespace tremolo
