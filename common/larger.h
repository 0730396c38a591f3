#pragma once

#include <cmath>

namespace tremolo {

// The larger of two numbers; NaN if one of them is, which std::max() may hide.
inline double larger(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

}  // namespace tremolo
