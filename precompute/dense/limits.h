// Measures this machine in some milliseconds and derives a lower bound for the time of a stage,
// from its arithmetic and from reading the factor.
#pragma once

#include <string>

#include "common/stage_log.h"

namespace tremolo {

// Rates of all `threads` together; zeros if not measured.
struct MachineLimits {
  double flops = 0;  // per second, of a dense product in double precision
  double bytes = 0;  // per second, read from memory
  double last_level_bytes =
      0;  // size of the last-level cache; a larger factor is read from memory in each pass
};
MachineLimits measure_machine(unsigned threads);

struct StageWork {
  double flops = 0;
  double factor_bytes = 0;  // size of the factor that is read
  double passes = 0;        // number of passes over it
  double added_flops = 0;   // of the work before the solves
};

// Lower bound for the time of a stage: added_flops, then the longer of arithmetic and reading,
// which may overlap. It holds for this algorithm, not for all algorithms. Small contributions
// (element loops, sparse products, orthogonalisation) are left out. reason: its composition, for
// the user.
struct StageLimit {
  double seconds = 0;
  std::string reason;
};
StageLimit stage_limit(const MachineLimits& machine, const StageWork& work);

// Adds the limit to the log of the current stage, if the machine was measured.
void set_limit(const MachineLimits& machine, const StageWork& work, StageLog& log);

}  // namespace tremolo
