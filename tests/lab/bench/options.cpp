#include "tests/lab/bench/options.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/integrator.h"

namespace tremolo::bench {
namespace {

template <class Names>
Status check_names(const char* what, const std::vector<std::string>& names, const Names& known) {
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      return Error{ErrorKind::kUsage, fmt::format("unknown {} '{}'; there are {}", what, name,
                                                  fmt::join(known, ", "))};
    if (std::count(names.begin(), names.end(), name) > 1)
      return Error{ErrorKind::kUsage, fmt::format("{} '{}' is named twice", what, name)};
  }
  return Success{};
}

Status check_values(const char* flag, const std::vector<double>& values) {
  if (values.empty()) return Error{ErrorKind::kUsage, fmt::format("{} names nothing", flag)};
  for (const double value : values)
    if (!(value > 0.0) || !std::isfinite(value))
      return content_error(fmt::format("{}: {} is not positive and finite", flag, value));
  return Success{};
}

template <class Order>
void sort_once(std::vector<double>& values, Order order) {
  std::sort(values.begin(), values.end(), order);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

Status check_duration(const Options& options) {
  const double smallest =
      1e-3 * std::min(options.steps_ms.back(), options.stability_steps_ms.back());
  const double longest = std::max(options.duration, options.stability_duration);
  if (!(options.duration > 0.0) || !std::isfinite(options.duration))
    return content_error("--duration must be positive and finite (s)");
  if (options.duration < 2.0 * kSample)
    return content_error(fmt::format("--duration must be at least {} s", 2.0 * kSample));
  if (longest / smallest > 1e9) return content_error("--steps-ms: more than 1e9 steps in a run");
  return Success{};
}

}  // namespace

Status settle(Options& options) {
  const auto known = integrator_names();
  if (Status s = check_names("integrator", options.integrators, known); !s) return s;
  constexpr std::string_view kLoads[] = {"square", "impulse", "sine"};
  if (Status s = check_names("load", options.loads, std::span(kLoads)); !s) return s;
  if (options.loads.empty()) return Error{ErrorKind::kUsage, "--loads names nothing"};
  if (!options.only.empty() && options.only != "precision" && options.only != "stability" &&
      options.only != "speed" && options.only != "hand" && options.only != "frames")
    return Error{
        ErrorKind::kUsage,
        "--only '" + options.only + "': there are precision, stability, speed, hand and frames"};
  if (Status s = check_values("--amplitudes", options.amplitudes); !s) return s;
  if (Status s = check_values("--steps-ms", options.steps_ms); !s) return s;
  for (const double step : options.steps_ms) {
    const double count = 1e3 * kSample / step;
    if (std::abs(count - std::round(count)) > 1e-9 * count || count < 0.5)
      return content_error(fmt::format(
          "--steps-ms: {} ms does not divide {} ms, from one recorded sample to the next", step,
          1e3 * kSample));
  }
  if (options.integrators.empty()) options.integrators.assign(known.begin(), known.end());
  sort_once(options.amplitudes, std::less());
  sort_once(options.steps_ms, std::greater());
  sort_once(options.stability_scales, std::less());
  sort_once(options.stability_steps_ms, std::greater());
  return check_duration(options);
}

}  // namespace tremolo::bench
