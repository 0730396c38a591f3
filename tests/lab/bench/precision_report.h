// The page, the files and the verdict of the precision part.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/bench/precision.h"
#include "tests/lab/report/page.h"

namespace tremolo::bench {

inline constexpr double kTargets[] = {1e-2, 1e-3, 1e-4};

// One row an entry, and one row a scene that was not measured.
Table bench_table(const Precision& precision);

// What is promised of ep4; empty if it was not run.
std::vector<Criterion> precision_criteria(const Precision& precision);

// For each target one sentence, computed from the standings.
std::vector<std::string> recommendations(const Precision& precision);

// bench.csv, cost.csv and scenes.csv in `directory`; sections on the page. Errors: kSystem.
Status report_precision(const Precision& precision, const std::string& directory, Page& page);

}  // namespace tremolo::bench
