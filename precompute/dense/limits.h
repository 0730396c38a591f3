// What this machine can do, measured in a few milliseconds, and the shortest time that leaves for a
// stage's arithmetic and for its reading of the factor.
#pragma once

#include <string>

#include "common/stage_log.h"

namespace tremolo {

// All `threads` together. Zeros: not measured.
struct MachineLimits {
  double flops = 0;             // a second, of a dense product in double precision
  double bytes = 0;             // a second, read from memory
  double last_level_bytes = 0;  // a factor larger than this has to come from memory each time
};
MachineLimits measure_machine(unsigned threads);

struct StageWork {
  double flops = 0;
  double factor_bytes = 0;  // of the factor that is read
  double passes = 0;        // how often
  double added_flops = 0;   // of what comes before the solves
};

// Arithmetic and reading may overlap: the longer of the two, after added_flops. A bound for the
// algorithm as it is, not for all algorithms; `reason` says what it is made of. What is small
// beside these (element loops, sparse products, orthogonalisation) is left out, so it is a lower
// bound.
struct StageLimit {
  double seconds = 0;
  std::string reason;
};
StageLimit stage_limit(const MachineLimits& machine, const StageWork& work);

// Says it with the stage that is under way, if the machine was measured.
void set_limit(const MachineLimits& machine, const StageWork& work, StageLog& log);

}  // namespace tremolo
