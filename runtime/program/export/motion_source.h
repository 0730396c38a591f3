// A motion for `tremolo export`: it has names and files, runs, and is recorded.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/program/export/animate.h"
#include "runtime/program/run/run_options.h"

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

}  // namespace tremolo
