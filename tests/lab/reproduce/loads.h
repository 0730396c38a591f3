// How hard the 36 runs push. The thesis gives no forces.
#pragma once

#include <string_view>

#include "runtime/load.h"

namespace tremolo::reproduce {

// Times the model's default load.
double load_factor(std::string_view model, SignalKind load);

}  // namespace tremolo::reproduce
