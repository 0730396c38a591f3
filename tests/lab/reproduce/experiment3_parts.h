// The tables and pictures of experiment 3.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/apps/tremolo/output/chart.h"
#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/report/table.h"
#include "tests/lab/reproduce/long_run.h"
#include "tests/lab/samples/thesis.h"

namespace tremolo::reproduce {

// label: of the method, with the difference from other runs of the same method.
struct LabelledRun {
  std::string label;
  LongRunSpec spec;
  LongRun run;

  double reached() const;        // s
  double window_length() const;  // s
};

// The last window's mean over the first's, less 1.
double change(const Windows& windows);

// A line through the windows' means of the high band, over time in s.
Fit high_band_trend(const LabelledRun& run);

// "+0.123 %"
std::string percent(double value);

// The thesis's row, then one per run.
Table total_energy_table(const std::vector<LabelledRun>& runs, const thesis::Thesis& thesis);
Table high_band_table(const std::vector<LabelledRun>& runs, const thesis::Thesis& thesis);

// Figure 17: the first and the last window, sample by sample, of the runs labelled imexv and ep4;
// and all windows' means of all runs. The values go into csv as well.
std::vector<Chart> figure17_charts(const std::vector<LabelledRun>& runs, Table& csv);
std::vector<Chart> windows_charts(const std::vector<LabelledRun>& runs, Table& csv);

}  // namespace tremolo::reproduce
