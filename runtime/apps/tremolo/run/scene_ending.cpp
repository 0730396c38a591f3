#include "runtime/apps/tremolo/run/scene_ending.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/energy_bound.h"

namespace tremolo {

Status apply_output_flags(const GivenFlags& flags, SceneOutputs& outputs) {
  if (flags.given("--out")) outputs.out = flags.values.out;
  if (flags.given("--every")) outputs.every = flags.values.every;
  if (flags.given("--surfaces")) outputs.surfaces = flags.values.surfaces;
  if (flags.given("--surface-format")) outputs.surface_format = flags.values.surface_format;
  if (flags.given("--plot")) outputs.plot = flags.values.plot;
  if (flags.given("--save")) outputs.save = flags.values.save;
  if (flags.given("--restore")) outputs.restore = flags.values.restore;
  if ((outputs.surfaces > 0 || outputs.plot) && outputs.out.empty())
    return usage_error("--surfaces and --plot need --out DIR");
  if (outputs.every < 1) return content_error("--every must be at least 1");
  if (outputs.surfaces < 0) return content_error("--surfaces must not be negative");
  return Success{};
}

Status check_times(const GivenFlags& flags, double step, double duration) {
  for (const auto& [flag, value] : {std::pair{"--step", step}, {"--duration", duration}})
    if (flags.given(flag) && !(value > 0.0 && std::isfinite(value)))
      return content_error(fmt::format("{} must be positive and finite (s)", flag));
  if (duration < 0.5 * step)
    return content_error(
        fmt::format("the duration, {:g} s, is shorter than half a step of {:g} s: nothing would be "
                    "done; give a longer --duration or a shorter --step",
                    duration, step));
  return Success{};
}

bool RunEnding::interrupted(int now, double time) {
  signal = now;
  if (signal == 0) return false;
  exit_code = 128 + signal;
  reason =
      fmt::format("ended at t = {:.6g} s by signal {} ({})", time, signal, ::strsignal(signal));
  return true;
}

void RunEnding::give_up(const StepReport& step, double time) {
  exit_code = tremolo::exit_code(error_kind(step.failure));
  reason = failure_message(step, time);
}

void RunEnding::give_up(double time) {
  exit_code = tremolo::exit_code(ErrorKind::kSolver);
  reason = fmt::format("the step from t = {:.6g} s could not be solved: take a shorter step", time);
}

void RunEnding::leave_bound(double energy, double time) {
  exit_code = tremolo::exit_code(ErrorKind::kBound);
  if (!std::isfinite(energy))
    reason = fmt::format("at t = {:.6g} s the energy is no longer a finite number", time);
  else
    reason = fmt::format(
        "at t = {:.6g} s the energy, {:.3g} J, is more than {:g} times all that was put in", time,
        energy, kEnergyBound);
}

void RunEnding::take(const std::string& body, const RunEnding& ending) {
  if (ending.exit_code == 0 || exit_code != 0) return;
  exit_code = ending.exit_code;
  reason = "body '" + body + "': " + ending.reason;
}

void add_ending(const RunEnding& ending, nlohmann::ordered_json& json) {
  json["exit_code"] = ending.exit_code;
  json["reason"] = ending.reason.empty() ? nlohmann::ordered_json(nullptr)
                                         : nlohmann::ordered_json(ending.reason);
}

int run_scene(const std::vector<NamedFile>& inputs, const RunOutputs& files,
              const SceneOutputs& outputs, bool print,
              const std::function<Result<SceneRun>()>& run) {
  if (Status s = files.check(inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  Result<SceneRun> made = run();
  if (!made) return report_error(made.error());
  auto& [json, ending, written] = *made;
  if (!outputs.out.empty()) {
    const std::string path = (std::filesystem::path(outputs.out) / kReportName).string();
    if (Status s = write_file(path, json_text(json)); !s) return report_error(s.error());
    written.push_back(path);
  }
  if (Status s = files.remove_earlier(written); !s) return report_error(s.error());
  if (!ending.reason.empty()) tell("tremolo: {}\n", ending.reason);
  if (print) print_json(json);
  const Status printed = flush_standard_output();
  if (ending.signal != 0) ::raise(ending.signal);
  return printed ? ending.exit_code : report_error(printed.error());
}

}  // namespace tremolo
