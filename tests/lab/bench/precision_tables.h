// The tables of the precision part.
#pragma once

#include <string>

#include "tests/lab/bench/precision.h"
#include "tests/lab/report/table.h"

namespace tremolo::bench {

std::string percent(double fraction);  // "0.1 %"

Table scene_table(const Precision& precision);  // every scene: its load, how far references agree

// Cost of each target, one row a scene and method.
Table cost_table(const Precision& precision);

// Cost of one target: rows models x amplitudes of one load, a column a method, the best named last.
Table cost_matrix(const Precision& precision, const std::string& load, double target);

// Median over scenes of cost_ratios(method, peer): rows methods, columns peers x targets.
Table ratio_table(const Precision& precision);

Table standing_table(const Precision& precision, double target);

}  // namespace tremolo::bench
