// Bodies of tetrahedra as a part of a report: what adaptive edges save, and what they cost.
#pragma once

#include <vector>

#include "tests/lab/report/report.h"
#include "tests/lab/work/store.h"

namespace tremolo::tets {

// Adds the section with tets.csv; the runs are in the store. Returns what was promised and
// measured. Throws a Failure.
std::vector<Criterion> add_tets_section(Report& report, const Store& store);

}  // namespace tremolo::tets
