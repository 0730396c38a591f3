// The sections, files and criteria of the precision part.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/bench/precision.h"
#include "tests/lab/report/report.h"

namespace tremolo::bench {

inline constexpr double kTargets[] = {1e-2, 1e-3, 1e-4};

// One row an entry, and one row a scene that was not measured.
Table bench_table(const Precision& precision);

// The criteria promised of ep4; empty if it was not run.
std::vector<Criterion> precision_criteria(const Precision& precision);

// For each target one sentence, computed from the standings.
std::vector<std::string> recommendations(const Precision& precision);

// Sections of the report, with bench.csv, cost.csv and scenes.csv. Throws a Failure (kSystem).
void report_precision(const Precision& precision, Report& report);

// Made by precision_tables.cpp.
std::string percent(double fraction);  // "0.1 %"

Table scene_table(const Precision& precision);  // every scene: its load, how far references agree

// Cost of each target, one row a scene and method.
Table cost_table(const Precision& precision);

// Cost of one target: rows are models and amplitudes of one load, columns the methods; the last
// column names the best.
Table cost_matrix(const Precision& precision, const std::string& load, double target);

// Median over scenes of cost_ratios(method, peer): rows methods, columns peers x targets.
Table ratio_table(const Precision& precision);

Table standing_table(const Precision& precision, double target);

}  // namespace tremolo::bench
