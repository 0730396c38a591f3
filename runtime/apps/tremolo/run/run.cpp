#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/run/simulate.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const RunReport& report, const BodyScene& scene) {
  Json json;
  json["schema"] = kReportSchema;
  add_body(report, json);
  json["load"] = scene.load_name;
  json["scale"] = number_or_null(report.scale);
  json["deflect"] = scene.deflect.empty() ? Json(nullptr) : Json(scene.deflect);
  json["start"] = scene.start.empty() ? Json(nullptr) : Json(scene.start);
  json["step"] = report.step;
  json["duration"] = report.duration;
  json["microseconds_per_step"] = number_or_null(report.microseconds_per_step);
  json["real_time_factor"] = number_or_null(report.step * 1e6 / report.microseconds_per_step);
  json["energy_reference"] = number_or_null(report.energy_reference);
  json["energy_drift_max"] = number_or_null(report.energy_drift_max);
  Json moves = Json::array();
  for (const SplitMove& move : report.moves)
    moves.push_back(
        {{"time", move.time}, {"low_before", move.low_before}, {"low_after", move.low_after}});
  json["split_moves"] = moves;
  json["stretch_min"] = number_or_null(report.stretch.smallest);
  json["stretch_max"] = number_or_null(report.stretch.largest);
  json["squeezed_at"] = report.squeezed_at < 0 ? Json(nullptr) : Json(report.squeezed_at);
  json["rigid_modes"] = report.rigid ? Json(report.rigid->rigid_modes) : Json(0);
  json["load_rigid_share"] = report.rigid ? number_or_null(report.rigid->share) : Json(nullptr);
  if (!scene.body().columns.probes.empty())
    json["largest_probe_displacement"] = number_or_null(report.largest_probe);
  add_ending(report, json);
  return json;
}

void print_rigid_loss(const RigidLoss& loss) {
  tell("  a free body: it vibrates where it is, {} motions without strain are left out",
       loss.rigid_modes);
  if (std::isfinite(loss.share))
    tell(
        ", and with them {:.3g} % of what this load sets in motion (net force {:.4g} N, torque "
        "{:.4g} N m about its centre; mass taken as spread evenly)\n",
        100 * loss.share, loss.force, loss.torque);
  else
    tell(", and with them what this load's net force of {:.4g} N and torque set in motion\n",
         loss.force);
}

Warnings warnings_of(const RunReport& report) {
  Warnings warnings;
  const std::string step = step_warning(report.first_frequency, report.step, "the ", "--step ");
  if (!step.empty()) warnings.push_back(step);
  if (!report.sound_warning.empty()) warnings.push_back(report.sound_warning);
  constexpr double kWrongLoss = 0.05;  // of the energy put in
  const double put_in = report.energy_put_in, loss = report.dissipated;
  if (report.exit_code == 0 && (loss < -kWrongLoss * put_in || loss > (1.0 + kWrongLoss) * put_in))
    warnings.push_back(fmt::format(
        "damping took {:.3g} J of the {:.3g} J that were put in: the step of {:.4g} s is too long "
        "for {} with this damping; take a shorter one, or ep4",
        loss, put_in, report.step, report.integrator));
  if (report.squeezed_at >= 0)
    warnings.push_back(fmt::format(
        "at t = {:.4g} s the surface is squeezed below {:.2f} of its length (at the worst to "
        "{:.2f}): StVK softens there and may turn inside out; use a smaller load or a stiffer "
        "material",
        report.squeezed_at, kSofteningStretch, report.stretch.smallest));
  return warnings;
}

void print_text(const RunReport& report, const Warnings& warnings) {
  tell("{}: {} reached {:.6g} of {:.6g} s in {} steps of {:.4g} s\n", report.name,
       report.integrator, report.reached, report.duration, report.steps, report.step);
  if (report.split)
    tell("  {} coordinates explicit, {} implicit\n", report.split->low, report.split->high);
  constexpr std::size_t kShown = 8;
  for (std::size_t i = 0; i < std::min(report.moves.size(), kShown); ++i)
    tell("  t = {:.6g} s: {} -> {} coordinates explicit\n", report.moves[i].time,
         report.moves[i].low_before, report.moves[i].low_after);
  if (report.moves.size() > kShown)
    tell("  ... and {} moves more (--json lists them)\n", report.moves.size() - kShown);
  if (report.halved_steps > 0) tell("  {} steps were taken in parts\n", report.halved_steps);
  const std::string pace = pace_text(report.step * 1e6 / report.microseconds_per_step);
  tell("  {:.2f} us a step{}, {:.2f} iterations\n", report.microseconds_per_step,
       pace.empty() ? pace : " (" + pace + ")", report.iterations_per_step());
  if (std::isfinite(report.energy_drift_max))
    tell("  energy {:.6g} J at the end, largest drift {:.2e}\n", report.energy_final,
         report.energy_drift_max);
  print_warnings(warnings);
  if (report.size > 0)
    tell("  moved by {:.4g} m at most, {:.3g} % of its size (vertex {}, t = {:.4g} s)\n",
         report.farthest.distance, 100 * report.farthest.distance / report.size,
         report.farthest.vertex, report.farthest_at);
  if (report.rigid) print_rigid_loss(*report.rigid);
}

Json report_of_all(const Json& bodies) {
  return {{"schema", kReportSchema}, {"bodies", bodies}};
}

// Writes report.json into the folder, if there is one.
Status write_report(const std::string& folder, const Json& json,
                    std::vector<std::string>& written) {
  if (folder.empty()) return Success{};
  written.push_back((std::filesystem::path(folder) / kReportName).string());
  return write_file(written.back(), json_text(json));
}

// Runs one body; prints and writes its report, and adds that to `objects`.
Status run_one(const BodyScene& body, unsigned threads, Json& objects, SceneRun& run) {
  Result<RunReport> report = simulate(body, threads);
  if (!report) return report.error();
  const Warnings warnings = warnings_of(*report);
  print_text(*report, warnings);
  objects.push_back(to_json(*report, body));
  objects.back()["warnings"] = warnings;
  std::vector<std::string>& files = report->files;
  const std::string& out = body.file.outputs.out;
  if (Status s = write_report(out, objects.back(), files); !s) return s;
  if (!out.empty()) tell("  wrote into {}: {}\n", out, list_files(files));
  run.written.insert(run.written.end(), files.begin(), files.end());
  run.ending.signal = report->signal;
  if (report->exit_code == 0) return Success{};
  tell("tremolo: {}: {}\n", report->name, report->reason);
  run.ending.exit_code = report->exit_code;
  return Success{};
}

// Several bodies also have a report of all in the folder above theirs.
Result<SceneRun> run_all(const std::vector<BodyScene>& bodies, unsigned threads) {
  SceneRun run;
  Json objects = Json::array();
  std::map<std::string, Json> reports;
  for (const BodyScene& body : bodies) {
    if (Status s = run_one(body, threads, objects, run); !s) return s.error();
    if (bodies.size() > 1) reports[folder_of_all(body, bodies)].push_back(objects.back());
    if (run.ending.signal != 0) break;
  }
  for (const auto& [folder, report] : reports)
    if (Status s = write_report(folder, report_of_all(report), run.written); !s) return s.error();
  run.json = objects.size() == 1 ? objects.front() : report_of_all(objects);
  return run;
}

}  // namespace

int run_command(const std::vector<BodyScene>& bodies, unsigned threads, bool json) {
  std::vector<NamedFile> inputs;
  for (const BodyScene& body : bodies)
    for (NamedFile& input : inputs_of(body)) inputs.push_back(std::move(input));
  return run_scene(inputs, outputs_of(bodies), {}, json,
                   [&bodies, threads] { return run_all(bodies, threads); });
}

}  // namespace tremolo
