#include "runtime/apps/tremolo/run/follow.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

Result<WorldEnding> follow(SceneWorld& world, const Following& how, WorldWatch& watch) {
  const std::int64_t before_it = world.steps();
  const std::int64_t last = std::llround(how.duration / world.step_size());
  WorldEnding ending;
  watch.note(world);
  if (Status s = watch.look(world, {}, ending); !s) return s.error();
  while (ending.exit_code == 0 && world.steps() < last) {
    std::span<const SceneWorld::Failure> failures;
    const std::int64_t end = std::min(world.steps() + how.block, last);
    const double before = how.clock();
    while (world.steps() < end && failures.empty()) {
      failures = world.step();
      watch.note(world);
    }
    ending.seconds += how.clock() - before;
    ending.steps = world.steps() - before_it;
    if (Status s = watch.look(world, failures, ending); !s) return s.error();
    how.progress->reached(world.time());
    if (how.interruption != nullptr) ending.interrupted(how.interruption->signal(), world.time());
  }
  return ending;
}

}  // namespace tremolo
