// What runs of all kinds of scenes share: flags of what is written, and how a run ends.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/program/run/run_files.h"
#include "runtime/program/run/run_options.h"
#include "runtime/scene_reader/scene_keys.h"

namespace tremolo {

// Puts the flags that were `told` in the place of what the scene says. Errors (kUsage, kContent):
// surfaces or a plot without a folder, counts out of range.
Status apply_output_flags(const RunOptions& flags, const std::function<bool(const char*)>& told,
                          SceneOutputs& outputs);

// Errors (kContent): --step or --duration (s), where given, is not positive and finite; the
// duration is shorter than half a step.
Status check_times(const std::function<bool(const char*)>& told, double step, double duration);

// How the run of a scene ended. signal: the one that interrupted it; 0: none.
struct SceneEnding {
  int exit_code = 0;
  int signal = 0;
  std::string reason;

  // Whether `now` is a signal: then it ended the run at that time (s).
  bool interrupted(int now, double time);
};

// Writes report.json into the run's folder, removes what earlier runs left there, tells why the run
// ended early, prints the JSON if the user asked for it, and raises the signal again. written: the
// paths of all other files of the run. Returns the program's exit code.
int end_scene_run(const SceneOutputs& outputs, const RunOutputs& files,
                  std::vector<std::string> written, const nlohmann::ordered_json& json,
                  const SceneEnding& ending, bool print);

}  // namespace tremolo
