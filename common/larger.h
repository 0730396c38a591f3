#pragma once

#include <cmath>

namespace tremolo {

// The larger of two numbers; not a number where one of them is none, which std::max() may hide.
inline double larger(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

}  // namespace tremolo
