// Output flags and the end of a run, common to all kinds of scenes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

// Flags that are given override the scene's outputs. Errors (kUsage, kContent): surfaces or a
// plot without a folder, counts out of range.
Status apply_output_flags(const GivenFlags& flags, SceneOutputs& outputs);

// Errors (kContent): --step or --duration (s), where given, is not positive and finite; the
// duration is shorter than half a step.
Status check_times(const GivenFlags& flags, double step, double duration);

// The end of the run of a scene. signal: the one that interrupted it; 0: none.
struct SceneEnding {
  int exit_code = 0;
  int signal = 0;
  std::string reason;

  // Whether `now` is a signal: then it ended the run at that time (s).
  bool interrupted(int now, double time);
};

// Adds exit_code and reason.
void add_ending(const SceneEnding& ending, nlohmann::ordered_json& json);

// The result of a run. written: the paths of all files but the report of all. ending.reason: empty
// if it has been printed.
struct SceneRun {
  nlohmann::ordered_json json;
  SceneEnding ending;
  std::vector<std::string> written;
};

// Runs a scene by `run`, once all files are known to be writable. Writes report.json into
// outputs.out, if there is one, removes files of earlier runs there, prints why the run ended
// early, prints the JSON if requested, and raises the signal again. Returns the program's exit
// code; errors are printed on stderr.
int run_scene(const std::vector<NamedFile>& inputs, const RunOutputs& files,
              const SceneOutputs& outputs, bool print,
              const std::function<Result<SceneRun>()>& run);

}  // namespace tremolo
