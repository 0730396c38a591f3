#include "precompute/reference/load_signal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

namespace tremolo {

Result<LoadShape> parse_load_shape(std::string_view name) {
  constexpr std::pair<std::string_view, LoadShape> kNames[] = {{"none", LoadShape::kNone},
                                                               {"impulse", LoadShape::kImpulse},
                                                               {"square", LoadShape::kSquare},
                                                               {"sine", LoadShape::kSine},
                                                               {"constant", LoadShape::kConstant}};
  for (const auto& [known, shape] : kNames)
    if (name == known) return shape;
  return Error{ErrorKind::kUsage, "unknown load '" + std::string(name) +
                                      "'; known: none, impulse, square, sine, constant"};
}

double load_end(LoadShape shape) {
  if (shape == LoadShape::kNone) return 0.0;
  if (shape == LoadShape::kImpulse) return 3e-3;
  if (shape == LoadShape::kSquare) return 0.3;
  return std::numeric_limits<double>::infinity();
}

double mean_load(LoadShape shape, double time, double step) {
  if (shape == LoadShape::kSine) {
    constexpr double kRate = 2.0 * std::numbers::pi;  // 1 Hz
    // The integral of the sine as a product: no cancellation for short steps.
    return 2.0 * std::sin(kRate * (time + 0.5 * step)) * std::sin(0.5 * kRate * step) /
           (kRate * step);
  }
  const double on = std::min(time + step, load_end(shape)) - time;
  // Rounding of k*h against the end is no load.
  return on <= 1e-9 * step ? 0.0 : on >= (1 - 1e-9) * step ? 1.0 : on / step;
}

}  // namespace tremolo
