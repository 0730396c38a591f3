#include "runtime/apps/tremolo/run/follow.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/processor.h"
#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo {
namespace {

// duration: s, which need not be a multiple of the step.
std::int64_t last_step(double duration, const SceneWorld& world) {
  return std::llround(duration / world.step_size());
}

}  // namespace

Status begin_run(const SceneFile& file, unsigned threads, SceneWorld& world) {
  if (Status s = world.set_threads(threads); !s) return s;
  const std::string& saved = file.outputs.restore;
  if (saved.empty()) return Success{};
  if (Status s = world.restore(saved); !s) return s;
  if (world.steps() > last_step(file.scene.duration, world))
    return content_error(
        fmt::format("{}: it was saved at t = {:.6g} s, behind the duration of "
                    "{:.6g} s",
                    saved, world.time(), file.scene.duration));
  return Success{};
}

Result<WorldEnding> follow(SceneWorld& world, const Following& how, WorldWatch& watch) {
  const std::int64_t before_it = world.steps();
  const std::int64_t last = last_step(how.duration, world);
  const clockid_t clock = how.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
  WorldEnding ending;
  watch.note(world);
  if (Status s = watch.look(world, {}, ending); !s) return s.error();
  while (ending.exit_code == 0 && world.steps() < last) {
    std::span<const SceneWorld::Failure> failures;
    const std::int64_t end = std::min(world.steps() + how.block, last);
    const double before = clock_seconds(clock);
    while (world.steps() < end && failures.empty()) {
      failures = world.step();
      watch.note(world);
    }
    ending.seconds += clock_seconds(clock) - before;
    ending.steps = world.steps() - before_it;
    if (Status s = watch.look(world, failures, ending); !s) return s.error();
    how.progress->reached(world.time());
    if (how.interruption != nullptr) ending.interrupted(how.interruption->signal(), world.time());
  }
  return ending;
}

Status save_end(const SceneFile& file, const SceneWorld& world, const RunEnding& ending) {
  const std::string& path = file.outputs.save;
  if (path.empty() || (ending.exit_code != 0 && ending.signal == 0)) return Success{};
  if (Status s = world.save(path); !s) return s;
  tell("saved at t = {:.6g} s: {}\n", world.time(), path);
  return Success{};
}

}  // namespace tremolo
