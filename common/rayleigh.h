// Rayleigh damping from damping ratios at two frequencies.
#pragma once

#include <string_view>

#include "common/result.h"

namespace tremolo {

// Damping alpha M + beta K: a mode of frequency w has the ratio alpha / (2 w) + beta w / 2.
struct RayleighDamping {
  double alpha = 0.0;  // 1/s
  double beta = 0.0;   // s
};

// text: "F1:Z1,F2:Z2", two frequencies in Hz and the fraction of critical damping at each. Modes
// between them are damped less, modes outside more. Errors: kUsage if the text has another form;
// kContent for frequencies that are not positive or equal, ratios outside [0, 1), and for a pair of
// ratios that alpha and beta could give only if one of them were negative, with the bounds.
Result<RayleighDamping> parse_damping_ratios(std::string_view text);

}  // namespace tremolo
