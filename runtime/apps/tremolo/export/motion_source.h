// A motion for `tremolo export`: it has names and files, runs, and is recorded.
#pragma once

#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/animate.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/scene/scene.h"

namespace tremolo {

struct MotionOutputs;

class MotionSource {
 public:
  virtual ~MotionSource() = default;

  // Names of the deforming bodies, in the order of the recording.
  virtual std::vector<std::string> names() const = 0;
  // Names of the scenery that is recorded with it.
  virtual std::vector<std::string> scenery() const { return {}; }
  // The files that a run of it reads.
  virtual std::vector<NamedFile> inputs() const = 0;
  // "30 s by `imexv` in steps of 3 ms".
  virtual std::string told() const = 0;
  // Errors (kUsage): formats or flags that it does not support. Called before the run.
  virtual Status check(const MotionOutputs& outputs) const = 0;
  // Runs it. colliders: they are recorded too. Errors: those of the run, and of frame_steps.
  virtual Result<RecordedMotion> record(const FrameRange& range, bool colliders) const = 0;
};

// Bodies as `tremolo run` takes them.
std::unique_ptr<MotionSource> bodies_motion(std::vector<RunOptions> bodies);
// A scene with [[bodies]].
std::unique_ptr<MotionSource> world_motion(SceneFile file);

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
