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
#include "runtime/integrator.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

// Flags that are given override the scene's outputs. Errors (kUsage, kContent): surfaces or a
// plot without a folder, counts out of range.
Status apply_output_flags(const GivenFlags& flags, SceneOutputs& outputs);

// Errors (kContent): --step or --duration (s), where given, is not positive and finite; the
// duration is shorter than half a step.
Status check_times(const GivenFlags& flags, double step, double duration);

// The end of a run, of a scene or of one of its bodies.
struct RunEnding {
  int exit_code = 0;   // 0; 4 or 5 if it broke off; 128 + n when signal n ended it
  int signal = 0;      // 0: none
  std::string reason;  // why exit_code is not 0

  // Whether `now` is a signal: then it ended the run at that time (s).
  bool interrupted(int now, double time);
  // A step failed; the step of a guest that begins at `time`, s.
  void give_up(const StepReport& step, double time);
  void give_up(double time);
  // The energy, J, is beyond its bound.
  void leave_bound(double energy, double time);
  // Ends as one of the bodies does, unless another one has ended it.
  void take(const std::string& body, const RunEnding& ending);
};

// Adds exit_code and reason.
void add_ending(const RunEnding& ending, nlohmann::ordered_json& json);

// The result of a run. written: the paths of all files but the report of all. ending.reason: empty
// if it has been printed.
struct SceneRun {
  nlohmann::ordered_json json;
  RunEnding ending;
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
