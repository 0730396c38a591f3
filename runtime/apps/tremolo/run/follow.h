// The run of a world from its start to the end of its time.
#pragma once

#include <cstdint>
#include <span>

#include "common/result.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// The end of a run of a world.
struct WorldEnding : RunEnding {
  double seconds = 0.0;    // of the steps: of the processor, with several threads real time
  std::int64_t steps = 0;  // that this run tried
};

// Measures and writes what a run reports. Energies, shapes and CSV rows use far more memory than a
// step and would evict a step's data from the caches: so a watch may note the states of a block of
// steps, and look at them when the block is complete.
class WorldWatch {
 public:
  virtual ~WorldWatch() = default;
  // At the start and after each step, within the measured time.
  virtual void note(const SceneWorld&) {}
  // At the start and after each block. failures: of its last step; without one all steps of the
  // block were made. The watch ends the run by a code and a reason. Errors: those of writing.
  virtual Status look(const SceneWorld& world, std::span<const SceneWorld::Failure> failures,
                      WorldEnding& ending) = 0;
};

// Settings of how a world is followed.
struct Following {
  double duration = 0.0;   // s, from the start of the world's time
  std::int64_t block = 1;  // steps between two looks, unless one fails
  unsigned threads = 1;    // of the world; several are timed by the wall's clock
  ToldProgress* progress = nullptr;
  const Interruption* interruption = nullptr;  // the signal that ends the run early; null: none
};

// Prepares the world's run: sets the number of threads that step it, 0: one per core, and its
// state, if the scene's outputs name a saved one. Errors: those of SceneWorld::restore; kContent
// for a state later than the scene's duration.
Status begin_run(const SceneFile& file, unsigned threads, SceneWorld& world);

// Steps the world to the end of its time, or to a block whose look or signal ends the run. Errors
// of the watch.
Result<WorldEnding> follow(SceneWorld& world, const Following& how, WorldWatch& watch);

// Saves the world if the scene's outputs name a file for it, also at the end of a run that a signal
// ended, but not if a step or an orbit failed. Errors: kSystem.
Status save_end(const SceneFile& file, const SceneWorld& world, const RunEnding& ending);

}  // namespace tremolo
