#include "runtime/program/export/frame_steps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace tremolo {

Result<FrameSteps> frame_steps(const FrameRange& range, double h, double duration) {
  if (!(range.rate > 0.0) || !std::isfinite(range.rate))
    return content_error(fmt::format("--rate {}: must be positive and finite", range.rate));
  const double to = range.to.value_or(duration);
  if (!(range.from >= 0.0) || !(to >= range.from))
    return content_error(
        fmt::format("--from {} --to {}: the range must begin at 0 or later and end behind that",
                    range.from, to));
  if (to > duration * (1.0 + 1e-9))
    return content_error(
        fmt::format("--to {}: the run lasts {} s; --duration makes it longer", to, duration));
  if (range.rate * h > 1.0 + 1e-9)
    return content_error(
        fmt::format("--rate {}: a second has only {:.6g} steps of {} s; --step {:.6g} makes more",
                    range.rate, 1.0 / h, h, 1.0 / range.rate));
  // A frame that the range's end just reaches is one of them, whatever the last digit says.
  const double count = std::floor((to - range.from) * range.rate + 1e-6) + 1.0;
  if (!(count < 1e8)) return content_error(fmt::format("{} frames are too many", count));
  FrameSteps frames;
  frames.even_step = 1.0 / (range.rate * std::ceil(1.0 / (range.rate * h) - 1e-9));
  const std::int64_t last = std::llround(duration / h);
  for (std::int64_t k = 0; static_cast<double>(k) < count; ++k) {
    const double wanted = range.from + static_cast<double>(k) / range.rate;
    const std::int64_t step = std::min<std::int64_t>(std::llround(wanted / h), last);
    if (!frames.steps.empty() && step <= frames.steps.back()) break;  // after the last step
    frames.steps.push_back(step);
    frames.offset = std::max(frames.offset, std::abs(static_cast<double>(step) * h - wanted));
  }
  return frames;
}

}  // namespace tremolo
