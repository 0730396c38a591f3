// Crowd: the step.
#include <algorithm>
#include <cmath>

#include "runtime/bodies/lanes/crowd_contents.h"

namespace tremolo {
namespace {

StepFailure failure_of(const LaneGroup::Outcome& outcome, std::size_t lane) {
  if ((outcome.failed >> lane & 1u) == 0) return StepFailure::kNone;
  if ((outcome.exploded >> lane & 1u) != 0) return StepFailure::kEnergy;
  if ((outcome.gave_up >> lane & 1u) != 0) return StepFailure::kSolver;
  return (outcome.loaded >> lane & 1u) != 0 ? StepFailure::kLoad : StepFailure::kNumbers;
}

}  // namespace

void Crowd::Contents::step(GroupId first, GroupId end) {
  report = {};
  failed.clear();
  failures.clear();
  std::size_t tasks = 0;
  for (GroupId g = first; g < end; ++g) {
    add_forces(groups[g]);
    report.stepped += groups[g].awake.size();
    tasks += groups[g].tasks();
    task_ends[g] = tasks;
  }
  pool->run(tasks, [&](std::size_t task, unsigned thread) {
    const auto at = std::upper_bound(task_ends.begin() + first, task_ends.begin() + end, task);
    const auto g = static_cast<GroupId>(at - task_ends.begin());
    run_task(groups[g], task - (g == first ? 0 : task_ends[g - 1]), scratch[thread]);
  });
  for (GroupId g = first; g < end; ++g) finish(groups[g]);
  report.failed = failed;
  report.why = failures;
}

void Crowd::Contents::add_forces(CrowdGroup& group) {
  for (const WorldForce& force : group.forces)
    group.lanes->add_force(bodies[force.body].slot, force.force.data());
}

void Crowd::Contents::run_task(CrowdGroup& group, std::size_t task, CrowdScratch& mine) {
  const int look = group.look();
  if (group.lanes) {
    group.outcomes[task] =
        group.lanes->step_block(task, {group.threshold, group.quiet_time, look}, mine.lanes);
    return;
  }
  const std::size_t index = bodies[group.awake[task]].index;
  Body& body = *group.bodies[index];
  const StepReport made = body.step();
  group.failed[task] = made.converged ? StepFailure::kNone : made.failure;
  if (look == 0 || !std::isfinite(group.quiet_time)) return;
  const bool below = body.energy().total() <= group.threshold && !body.load_to_come();
  group.quiet[index] = below ? group.quiet[index] + look * group.options.step : 0.0;
}

// From the last slot down: a body that leaves is replaced by the last, which is already done.
void Crowd::Contents::finish(CrowdGroup& group) {
  const bool looked = group.look() != 0;
  ++group.steps;
  for (WorldForce& force : group.forces)
    if (--force.steps == 0) --bodies[force.body].forces;
  std::erase_if(group.forces, [](const WorldForce& force) { return force.steps == 0; });
  if (group.lanes) {
    const std::size_t lanes = group.lanes->lanes();
    for (std::size_t block = group.tasks(); block-- > 0;) {
      const LaneGroup::Outcome outcome = group.outcomes[block];
      if ((outcome.failed | outcome.quiet) == 0) continue;
      for (std::size_t lane = lanes; lane-- > 0;)
        finish_body(group, block * lanes + lane, failure_of(outcome, lane),
                    outcome.quiet >> lane & 1u);
    }
    return;
  }
  for (std::size_t slot = group.awake.size(); slot-- > 0;) {
    const std::size_t index = bodies[group.awake[slot]].index;
    finish_body(group, slot, group.failed[slot],
                looked && group.quiet[index] >= group.quiet_time && group.quiet[index] > 0.0);
  }
}

void Crowd::Contents::finish_body(CrowdGroup& group, std::size_t slot, StepFailure failure,
                                  bool quiet) {
  const bool has_failed = failure != StepFailure::kNone;
  if (!has_failed && !quiet) return;
  const BodyId id = group.awake[slot];
  if (!has_failed && bodies[id].forces > 0) return;
  if (has_failed) {
    failed.push_back(id);
    failures.push_back(failure);
  } else {
    ++report.fell_asleep;
  }
  sleep(id);
}

}  // namespace tremolo
