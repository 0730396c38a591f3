// Pictures by gnuplot.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// One run: a label and its run.csv.
struct PlotSource {
  std::string label;
  std::string csv;
};

// Total and high-band energy of the runs over time, stacked panels, one curve a run. The ending of
// `output` chooses .svg or .png. Errors: kUsage for another ending, kSystem if gnuplot is missing
// (the message tells how to get it) or fails.
Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output);

}  // namespace tremolo
