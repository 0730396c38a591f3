// `tremolo bench`: run time against error, and where each method survives.
#pragma once

#include "tests/lab/bench/options.h"

namespace tremolo::bench {

// Writes index.html and CSVs into options.out, works from options.out/work where it was stopped.
// Returns the exit code: 6 if a deciding criterion is missed; errors are printed.
int run(Options options);

}  // namespace tremolo::bench
