// Damping as it is measured: fractions of critical damping.
#pragma once

#include <string_view>
#include <vector>

#include "common/material.h"
#include "common/result.h"

namespace tremolo {

// A ratio at a frequency.
struct RatioAt {
  double frequency = 0.0;  // Hz
  double ratio = 0.0;      // of critical damping
};

// Only one of the three is set.
struct DampingRatios {
  RayleighDamping rayleigh;
  // Of mode 1, 2, ...; all further modes have the last one.
  std::vector<double> of_modes;
  // By ascending frequency, straight lines between, constant outside.
  std::vector<RatioAt> table;

  bool of_each_mode() const { return !of_modes.empty() || !table.empty(); }
};

// text: "2%" or "0.02", every mode's ratio; "2%,1%,0.5%", one for each mode; "F1:Z1,F2:Z2",
// Rayleigh damping (common/material.h); or three pairs and more, a table. Errors: kUsage if the
// text has another form; kContent for ratios outside [0, 1), frequencies that are not positive or
// do not ascend, and the reasons of rayleigh_damping.
Result<DampingRatios> parse_damping(std::string_view text);

// Rayleigh damping with the ratio z1 at f1 (Hz) and z2 at f2. text: their source, for errors, which
// are the kContent ones of parse_damping_ratios.
Result<RayleighDamping> rayleigh_damping(double f1, double z1, double f2, double z2,
                                         std::string_view text);

// The ratio of mode `mode` (from 0) of this frequency (Hz); 0 of Rayleigh damping.
double ratio_of(const DampingRatios& ratios, std::size_t mode, double frequency);

}  // namespace tremolo
