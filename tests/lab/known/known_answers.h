// The experiments whose answer others know, as a part of a report: the chain of Fermi, Pasta, Ulam
// and Tsingou, linear resonance, the pendulum, what one step keeps, the trend of the energy.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tests/lab/report/page.h"
#include "tests/lab/report/store.h"

namespace tremolo {

// Adds five sections to the page and writes known-*.csv into out_directory, which exists.
// long_form: the energy is followed for a million steps instead of a hundred thousand. Returns what
// was promised and measured; the page shows the same list section by section. Errors: kSystem if a
// file cannot be written or gnuplot is missing; those of the store.
Result<std::vector<Criterion>> add_known_answers(Page& page, const Store& store,
                                                 const std::string& out_directory, bool long_form);

}  // namespace tremolo
