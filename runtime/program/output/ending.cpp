#include "runtime/program/output/ending.h"

#include <fmt/format.h>

#include "common/result.h"
#include "runtime/energy_bound.h"

namespace tremolo {

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
