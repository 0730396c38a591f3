// The end of an orbit: its exit code and, if it ended early, the reason.
#pragma once

#include <string>

#include "runtime/integrator.h"

namespace tremolo {

// exit_code: 0; 4 if the solver gave up; 5 if the energy bound was left (as `tremolo run`).
struct Ending {
  int exit_code = 0;
  std::string reason;

  bool finished() const { return exit_code == 0; }
  void solver_gave_up(const StepReport& step);
  void bound_left();
};

}  // namespace tremolo
