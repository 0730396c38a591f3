// Which steps of a run become frames of what is exported.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/result.h"

namespace tremolo {

// rate: frames a second. from, to: s, of the run; to: nothing: its end.
struct FrameRange {
  double rate = 60.0;
  double from = 0.0;
  std::optional<double> to;
};

// steps: ascending numbers of steps. Frame k is the state at the end of the step that lies nearest
// to from + k/rate; its own time is step times h. offset: how far the two are apart at most, s.
struct FrameSteps {
  std::vector<std::int64_t> steps;
  double offset = 0.0;
  double even_step = 0.0;
};

// h: the step, s; duration: of the run, s. Errors: kContent for an empty range, one beyond the run,
// or more frames than steps.
Result<FrameSteps> frame_steps(const FrameRange& range, double h, double duration);

}  // namespace tremolo
