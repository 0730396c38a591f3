// The thesis's figures of energy over time.
#pragma once

#include <string>

#include "common/result.h"
#include "tests/lab/report/page.h"
#include "tests/lab/reproduce/runs.h"

namespace tremolo::reproduce {

// Figures 13-16 (horse) and 22-35, as far as their models are there: each on the page and as
// figure-NN.csv (thinned as drawn) in `directory`. Errors: those of drawing and writing.
Status add_energy_figures(Page& page, const Workshop& shop, const Orbits& orbits,
                          const std::string& directory);

// Figures 18 and 19: the beam at 10, 5 and 1 ms. Runs them. Nothing without the beam.
Status add_step_figures(Page& page, const Workshop& shop, const std::string& directory);

}  // namespace tremolo::reproduce
