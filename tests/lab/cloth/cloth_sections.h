// The study of cloth as sections of a report.
#pragma once

#include <vector>

#include "tests/lab/report/report.h"

namespace tremolo::cloth_study {

// Adds the study with cloth-study.csv, and the two sections below. threads: for the runs; the
// milliseconds are processor time. Throws a Failure.
std::vector<Criterion> add_cloth_sections(Report& report, unsigned threads);

// Predicted and observed limits of stability on three sheets, with cloth-limits.csv.
std::vector<Criterion> add_cloth_limits(Report& report, unsigned threads);

// Cost of a step: hanging sheets of 100 x 100 and of 100 000 particles by implicit-euler at 1/60 s,
// whose structural springs have h omega_max = 30, and 50 x 50 by symplectic-euler, with
// cloth-speed.csv. The criteria decide nothing: times depend on the machine.
std::vector<Criterion> add_cloth_speed(Report& report);

}  // namespace tremolo::cloth_study
