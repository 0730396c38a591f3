// Measured frequencies and damping of a body, from a CSV file.
//
// The first line names the columns, in any order: `mode` (1, 2, ...), `frequency` (Hz),
// `frequency_sd`, `damping_ratio` (0.02 or 2%), `damping_ratio_sd`, `decay_time` (s, in which a
// ring-down falls to 1/e), `decay_time_sd`. A cell may be empty. # begins a comment.
//
// A ring-down is that of the damped oscillation: frequencies are those of its zeros, and the
// frequency without damping follows from both. One that falls to 1/e within a period does not ring:
// such a time is in the wrong unit, or of another mode.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// A value and its standard deviation, in the same unit; 0: not known.
struct Uncertain {
  double value = 0.0;
  double deviation = 0.0;
};

struct MeasuredMode {
  std::optional<int> mode;             // from 0; none: found by the frequency
  std::optional<Uncertain> frequency;  // without damping, Hz
  std::optional<Uncertain> ratio;      // of critical damping
  std::optional<Uncertain> decay;      // s; the ratio follows from it
  double stretch = 1.0;                // the frequency without damping over that of the ringing
  int line = 0;                        // of the file
};

struct Measurements {
  std::vector<MeasuredMode> rows;  // at least one, in the order of the file
  // The deviations of all frequencies, or ratios, are known; else of none.
  bool frequency_deviations = false, ratio_deviations = false;
};

// Errors (kContent) with the line: an unknown or missing column, a cell that is no number or out of
// range, a mode or a frequency twice, a row without both, deviations of some rows only, a decay
// shorter than the period.
Result<Measurements> parse_measurements(std::string_view text, const std::string& path);

// Also kSystem for a file that cannot be read.
Result<Measurements> read_measurements(const std::string& path);

}  // namespace tremolo
