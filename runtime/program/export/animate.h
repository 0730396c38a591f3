// Runs bodies or a world and records what they do.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"
#include "runtime/program/export/frame_steps.h"
#include "runtime/program/run/run_options.h"
#include "runtime/scene_reader/scene_reader.h"

namespace tremolo {

// offset, even_step: as of FrameSteps. left_out: names of colliders that have no triangles.
struct RecordedMotion {
  Animation animation;
  double offset = 0.0;
  double even_step = 0.0;
  std::vector<std::string> left_out;
};

// Bodies as `tremolo run` starts and steps them, each by itself; steps and durations must agree.
// Errors: those of prepare_run and make_body; kContent for a range that does not fit; kSolver and
// kBound for a step that could not be made.
Result<RecordedMotion> animate_bodies(const std::vector<RunOptions>& bodies,
                                      const FrameRange& range);

// A scene with [[bodies]]. colliders: they are recorded too. Errors: those of SceneWorld::create,
// and as above.
Result<RecordedMotion> animate_world(const SceneFile& file, const FrameRange& range,
                                     bool colliders);

}  // namespace tremolo
