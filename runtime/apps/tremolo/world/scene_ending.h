// Output flags and the end of a run, common to all kinds of scenes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

// Flags that are `given` override the scene's outputs. Errors (kUsage, kContent): surfaces or a
// plot without a folder, counts out of range.
Status apply_output_flags(const RunOptions& flags, const std::function<bool(const char*)>& given,
                          SceneOutputs& outputs);

// Errors (kContent): --step or --duration (s), where given, is not positive and finite; the
// duration is shorter than half a step.
Status check_times(const std::function<bool(const char*)>& given, double step, double duration);

// The end of the run of a scene. signal: the one that interrupted it; 0: none.
struct SceneEnding {
  int exit_code = 0;
  int signal = 0;
  std::string reason;

  // Whether `now` is a signal: then it ended the run at that time (s).
  bool interrupted(int now, double time);
};

// Writes report.json into the run's folder, removes files of earlier runs there, prints why the run
// ended early, prints the JSON if requested, and raises the signal again. written: the paths of all
// other files of the run. Returns the program's exit code.
int end_scene_run(const SceneOutputs& outputs, const RunOutputs& files,
                  std::vector<std::string> written, const nlohmann::ordered_json& json,
                  const SceneEnding& ending, bool print);

}  // namespace tremolo
