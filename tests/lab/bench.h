// `tremolo bench`: run time against error, and where each method survives.
#pragma once

#include "tests/lab/bench/options.h"

namespace tremolo::bench {

// Writes index.html, report.json and CSVs into options.out, and continues from options.out/work.
// Returns 0, or 6 if a deciding criterion is missed; throws a Failure.
int run(Options options);

}  // namespace tremolo::bench
