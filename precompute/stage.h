// What surrounds a stage of the pipeline: it is found in the checkpoint or made and kept, timed,
// and told. The computations themselves see none of this.
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
  std::function<std::string(const Value&)> outcome;                  // for the log, one line
  std::function<std::vector<std::string>(const Value&)> notes = {};  // further lines
  std::function<StageWork(const Value&)> work = {};                  // of a value that was made
  std::function<std::optional<Value>()> find = {};                   // nothing: it is not kept
  std::function<void(const Value&)> keep = {};
};

// machine: with zeros no stage has a limit.
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
