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

// Total energy of the runs over time, one curve a run, and below it that of the high band for those
// that have one (`tremolo-precompute reference` has none). The ending of `output` chooses .svg or
// .png. Errors: kUsage for another ending, kContent for a CSV without the columns t and total,
// kSystem if gnuplot is missing (the message tells how to get it) or fails.
Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output);

// `tremolo plot`: the energies of these folders of `tremolo run --out`. The exit code; errors are
// printed on stderr.
int plot_command(const std::vector<std::string>& directories, const std::string& output);

}  // namespace tremolo
