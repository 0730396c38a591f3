#include "runtime/apps/tremolo/output/warnings.h"

#include <cmath>

#include <fmt/format.h>

#include "common/result.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/energy_bound.h"

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

void Ending::solver_gave_up(const StepReport& step) {
  if (step.failure == StepFailure::kEnergy) return bound_left();
  exit_code = tremolo::exit_code(ErrorKind::kSolver);
  reason = fmt::format("a step did not converge in {} iterations", step.iterations);
}

void Ending::bound_left() {
  exit_code = tremolo::exit_code(ErrorKind::kBound);
  reason = fmt::format("energy above {:g} times all that was put in", kEnergyBound);
}

}  // namespace tremolo
