#include <cmath>

#include "precompute/reference/reference_options.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require(bool good, const char* message) {
  if (!good) throw Failure(content_error(message));
}

}  // namespace

void check_reference(const ReferenceOptions& options) {
  const TimeSettings& time = options.time;
  require(time.step > 0 && std::isfinite(time.step), "--step must be positive and finite (s)");
  require(options.duration > 0 && std::isfinite(options.duration),
          "--duration must be positive and finite (s)");
  require(options.statics || options.duration >= 0.5 * time.step,
          "--duration is shorter than half a step: nothing would be done");
  require(options.duration / time.step <= 1e9, "--duration and --step ask for more than 1e9 steps");
  require(time.alpha >= 0 && std::isfinite(time.alpha),
          "--alpha must not be negative, and finite (1/s)");
  require(time.beta >= 0 && std::isfinite(time.beta),
          "--beta must not be negative, and finite (s)");
  require(std::isfinite(options.scale), "--scale must be finite");
  require(options.gravity.allFinite(), "--gravity must be finite (m/s^2)");
  require(options.tolerance > 0 && options.tolerance < 1, "--tolerance must be between 0 and 1");
  require(options.max_iterations >= 1, "--max-iterations must be at least 1");
  require(options.every >= 1, "--every must be at least 1");
}

}  // namespace tremolo
