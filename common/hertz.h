#pragma once

#include <cmath>
#include <numbers>

namespace tremolo {

// The frequency in Hz of a squared angular frequency, (rad/s)^2.
inline double hertz(double squared_frequency) {
  return std::sqrt(squared_frequency) / (2.0 * std::numbers::pi);
}

}  // namespace tremolo
