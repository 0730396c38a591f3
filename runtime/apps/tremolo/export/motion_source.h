// A motion for `tremolo export`: it has names and files, runs, and is recorded.
#pragma once

#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/animate.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/scene/scene.h"

namespace tremolo {

struct MotionSource {
  std::vector<std::string> names;    // of the deforming bodies, in the order of the recording
  std::vector<std::string> scenery;  // names of the scenery that is recorded with it
  std::vector<NamedFile> inputs;     // files that a run of it reads
  std::string description;           // "30 s by `imexv` in steps of 3 ms"
  // Errors of --modes and of --live; empty: the motion supports them.
  std::string no_modes = {}, no_live = {};
  // Runs it. colliders: they are recorded too. Errors: those of the run, and of frame_steps.
  std::function<Result<RecordedMotion>(const FrameRange& range, bool colliders)> record;
};

// Bodies as `tremolo run` takes them, each by itself.
MotionSource bodies_motion(std::vector<BodyScene> bodies);
// A scene with [[bodies]].
MotionSource world_motion(MixedFile mixed);

// colliders: numbers of the recorded ones, in that order. left_out: names of colliders without
// triangles, whose file has only distances.
struct Scenery {
  std::vector<std::size_t> colliders;
  std::vector<std::string> left_out;
};

// Adds a body without coordinates. taken: names of all bodies so far; an existing name gets
// "-collider" appended.
void add_scenery(AnimatedShape shape, std::string name, std::set<std::string>& taken,
                 Animation& animation);

// Adds the colliders, with planes if requested. Planes extend over the sizes and positions of all
// shapes at rest, with a margin.
Scenery add_colliders(std::span<const SceneCollider> colliders, bool planes,
                      std::set<std::string>& taken, Animation& animation);

}  // namespace tremolo
