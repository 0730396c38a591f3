// Selects the steps of a run that become exported frames.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/result.h"

namespace tremolo {

// The requested frames.
struct FrameRange {
  double rate = 60.0;        // frames per second
  double from = 0.0;         // s, of the run
  std::optional<double> to;  // s; empty: the end of the run
};

// Frame k is the state at the end of the step nearest to from + k/rate; its own time is step times
// h.
struct FrameSteps {
  std::vector<std::int64_t> steps;  // numbers of steps, ascending
  double offset = 0.0;              // the largest difference between the two times, s
  double even_step = 0.0;           // a step, s, with which the difference would be zero
};

// h: the step, s; duration: of the run, s. Errors: kContent for an empty range, one beyond the run,
// or more frames than steps.
Result<FrameSteps> frame_steps(const FrameRange& range, double h, double duration);

}  // namespace tremolo
