// Searches the factor of the load for a requested amplitude of the motion.
#pragma once

#include <functional>
#include <string>

#include "common/result.h"

namespace tremolo {

// The result of one factor. amplitude: the largest displacement over the size, infinite if the run
// ended early; reason: why it did.
struct LoadAttempt {
  double scale = 0.0;
  double amplitude = 0.0;
  std::string reason = {};
};

// scale: zero if none was found; `trouble` says why.
struct LoadScale {
  double scale = 0.0;
  std::string trouble;
};

// Tries factors of four digits, the first one 0.01, until the amplitude is within 1 % of the
// requested one. Errors: those of `attempt`.
Result<LoadScale> search_load_scale(double wanted,
                                    const std::function<Result<LoadAttempt>(double)>& attempt);

}  // namespace tremolo
