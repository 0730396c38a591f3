// Bodies of tetrahedra as a part of a report: benefit and cost of adaptive edges.
#pragma once

#include <vector>

#include "tests/lab/report/report.h"
#include "tests/lab/work/store.h"

namespace tremolo::tets {

// Adds the section with tets.csv; the runs are in the store. Returns the criteria with their
// measurements. Throws a Failure.
std::vector<Criterion> add_tets_section(Report& report, const Store& store);

}  // namespace tremolo::tets
