// Frame of a pipeline stage: reads it from the checkpoint or computes and saves it, measures its
// time, and logs it. The computations do not depend on this.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/stage_log.h"
#include "precompute/dense/limits.h"

namespace tremolo {

template <class Value>
struct Stage {
  std::string name;
  std::function<Value()> make;
  std::function<std::string(const Value&)> outcome;                  // one line for the log
  std::function<std::vector<std::string>(const Value&)> notes = {};  // further lines
  std::function<StageWork(const Value&)> work = {};                  // of a computed value
  std::function<std::optional<Value>()> find = {};                   // none: not in the checkpoint
  std::function<void(const Value&)> keep = {};
};

// machine: zeros give no limits.
template <class Value>
Value run_stage(const Stage<Value>& stage, const MachineLimits& machine, StageLog& log) {
  log.begin(stage.name);
  std::optional<Value> kept = stage.find ? stage.find() : std::nullopt;
  const bool found = kept.has_value();
  Value value = found ? std::move(*kept) : stage.make();
  if (!found && stage.keep) stage.keep(value);
  if (!found && stage.work) set_limit(machine, stage.work(value), log);
  log.end(stage.outcome(value) + (found ? ", from the checkpoint" : ""));
  if (stage.notes)
    for (const std::string& note : stage.notes(value)) log.note(note);
  return value;
}

}  // namespace tremolo
