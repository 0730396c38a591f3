// Runs bodies or a world and records what they do.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/run/body_scene.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/io/scenes/nodal_readers.h"

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

// offset, even_step: as of FrameSteps. left_out: names of colliders that have no triangles.
struct RecordedMotion {
  Animation animation;
  double offset = 0.0;
  double even_step = 0.0;
  std::vector<std::string> left_out;
};

// What film() steps and records.
struct Filmed {
  std::string name;                                  // of the progress
  std::function<double()> time;                      // s
  std::function<Status(std::int64_t step)> step_to;  // to the end of that step
  std::function<Status(Recording&)> record;          // the frame that was begun
};

// Steps to each frame and records it. duration: of the run, s. Errors: those of the functions and
// of Recording.
Result<RecordedMotion> film(const Filmed& filmed, const FrameRange& range, const FrameSteps& frames,
                            double duration);

// The error of a step of a body that could not be made. time: at its start, s.
Error step_error(const std::string& name, const StepReport& report, double time);

// Bodies as `tremolo run` starts and steps them, each by itself; steps and durations must agree.
// Errors: those of prepare_run and world_of_one; kContent for a range that does not fit; kSolver
// and kBound for a step that could not be made.
Result<RecordedMotion> animate_bodies(const std::vector<BodyScene>& bodies,
                                      const FrameRange& range);

// A scene with [[bodies]]: its bodies, colliders where requested, and guests. Errors: those of
// SceneWorld::create() and add_guests(), and as above.
Result<RecordedMotion> animate_world(const MixedFile& mixed, const FrameRange& range,
                                     bool colliders);

}  // namespace tremolo
