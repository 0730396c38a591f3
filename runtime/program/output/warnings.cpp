#include "runtime/program/output/warnings.h"

#include <cmath>

#include <fmt/format.h>

#include "runtime/program/output/tell.h"

namespace tremolo {

void print_warnings(const Warnings& warnings) {
  for (const std::string& warning : warnings) tell("  warning: {}\n", warning);
}

double resolving_step(double frequency) {
  return 1.0 / (kStepsAPeriod * frequency);
}

std::string step_warning(double frequency, double step, const std::string& whose,
                         const std::string& flag) {
  // Rounding aside: a step that was taken from the warning draws no other one.
  if (!(frequency > 0.0) || step <= resolving_step(frequency) * (1.0 + 1e-3)) return {};
  return fmt::format(
      "{}first mode, {:.4g} Hz, has {:.3g} steps of {:.4g} s a period, too few to follow its "
      "vibration: use {}{:.4g} ({:g} steps a period) or less",
      whose, frequency, 1.0 / (frequency * step), step, flag, resolving_step(frequency),
      kStepsAPeriod);
}

std::string pace_text(double factor) {
  if (!std::isfinite(factor)) return {};
  const bool slower = factor < 1.0;
  const double times = slower ? 1.0 / factor : factor;
  return fmt::format("{} times {} than real time",
                     times < 100.0 ? fmt::format("{:.2g}", times) : fmt::format("{:.0f}", times),
                     slower ? "slower" : "faster");
}

}  // namespace tremolo
