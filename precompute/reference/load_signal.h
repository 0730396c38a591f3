// Loads in time, with the shapes of `tremolo run` (docs/architecture.md): what the reference does
// not share with the runtime is this definition, since the two rooms do not meet.
#pragma once

#include <string_view>

#include "common/result.h"

namespace tremolo {

// Height 1, dimensionless: kImpulse for 3 ms, kSquare for 0.3 s, kSine sin(2 pi t) of 1 Hz and
// kConstant for ever; all begin at t = 0.
enum class LoadShape { kNone, kImpulse, kSquare, kSine, kConstant };

// "none", "impulse", "square", "sine", "constant"; kUsage with the list otherwise.
Result<LoadShape> parse_load_shape(std::string_view name);

double load_end(LoadShape shape);  // s; infinity if it lasts, 0 for kNone

// (1/step) times the integral over [time, time + step]: a load shorter than a step hands on its
// whole impulse.
double mean_load(LoadShape shape, double time, double step);

}  // namespace tremolo
