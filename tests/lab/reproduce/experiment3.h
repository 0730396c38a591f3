// Experiment 3: does the energy stay over 10 000 s? Table, figure 17, criteria.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tests/lab/report/page.h"
#include "tests/lab/reproduce/runs.h"

namespace tremolo::reproduce {

// On the horse; nothing without it. The criteria for ep4, if there is one. Writes experiment-3.csv,
// experiment-3-windows.csv and figure-17.csv. Errors: those of the runs, of drawing, of writing.
Result<std::vector<Criterion>> add_experiment3(Page& page, const Workshop& shop,
                                               const std::string& directory);

}  // namespace tremolo::reproduce
