// Damping as it is measured: fractions of critical damping.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/material.h"
#include "common/result.h"
#include "common/state_stream.h"

namespace tremolo {

// A ratio at a frequency.
struct RatioAt {
  double frequency = 0.0;  // Hz
  double ratio = 0.0;      // of critical damping

  bool operator==(const RatioAt&) const = default;
  void carry(StateStream& stream) { stream(frequency, ratio); }
};

// Only one of the three is set.
struct DampingRatios {
  RayleighDamping rayleigh;
  // Of mode 1, 2, ...; all further modes have the last one.
  std::vector<double> of_modes;
  // By ascending frequency, straight lines between, constant outside.
  std::vector<RatioAt> table;

  bool of_each_mode() const { return !of_modes.empty() || !table.empty(); }
  bool operator==(const DampingRatios& other) const {
    return rayleigh.alpha == other.rayleigh.alpha && rayleigh.beta == other.rayleigh.beta &&
           of_modes == other.of_modes && table == other.table;
  }
  void carry(StateStream& stream) {
    stream(rayleigh.alpha, rayleigh.beta);
    stream.sized(of_modes);
    stream.sized(table);
  }
};

// text: "2%" or "0.02", every mode's ratio; "2%,1%,0.5%", one for each mode; "F1:Z1,F2:Z2",
// Rayleigh damping (common/material.h); or three pairs and more, a table. Errors: kUsage if the
// text has another form; kContent for ratios outside [0, 1), frequencies that are not positive or
// do not ascend, and the reasons of rayleigh_damping.
Result<DampingRatios> parse_damping(std::string_view text);

// Errors (kContent): a ratio outside [0, 1), a frequency that is not positive, or that does not
// ascend, both a list and a table, more ratios than `modes`.
Status check_ratios(const DampingRatios& ratios, std::size_t modes);

// Rayleigh damping with the ratio z1 at f1 (Hz) and z2 at f2. Modes between them are damped less,
// modes outside more. text: their source, for errors (kContent): frequencies that are not positive
// or equal, ratios outside [0, 1), and a pair of ratios that alpha and beta could give only if one
// of them were negative, with the bounds.
Result<RayleighDamping> rayleigh_damping(double f1, double z1, double f2, double z2,
                                         std::string_view text);

// A decimal that is read as exactly this number, of six digits where they are enough.
std::string exact_text(double value);

// A text that parse_damping reads as exactly these ratios of each mode; empty for none.
std::string ratios_text(const DampingRatios& ratios);

// The ratio of mode `mode` (from 0) of this frequency (Hz); 0 of Rayleigh damping.
double ratio_of(const DampingRatios& ratios, std::size_t mode, double frequency);

}  // namespace tremolo
