#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "common/processor.h"
#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/cloth/cloth_commands.h"
#include "runtime/apps/tremolo/measure/cloth_log.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/statistics.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/bodies/cloth/cloth_model.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// The end of a run. each: processor time of every step, us.
struct ClothEnding : RunEnding {
  std::vector<double> each;
};

std::size_t all_particles(const ClothWorld& world) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < world.cloths(); ++i) count += world.particles(i);
  return count;
}
std::size_t all_springs(const ClothWorld& world) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < world.cloths(); ++i) count += world.model(i).springs();
  return count;
}

void add_energy_keys(Json& json, const ClothReport& report) {
  const ClothEnergy &start = report.start, &end = report.end;
  json["energy_initial"] = number_or_null(start.total());
  json["energy_final"] = number_or_null(end.total());
  json["energy_max"] = number_or_null(report.balance.energy_max);
  json["kinetic_final"] = number_or_null(end.kinetic);
  json["elastic_final"] = number_or_null(end.elastic);
  json["gravity_final"] = number_or_null(end.gravity);
  json["energy_by_cause"] = {{"wind", number_or_null(end.wind)},
                             {"support", number_or_null(end.pins)},
                             {"contact", number_or_null(end.contact)},
                             {"damping", number_or_null(-end.damped)},
                             {"method", number_or_null(end.numerical)}};
  json["energy_balance_error"] = number_or_null(report.balance.error());
  json["work"] = number_or_null(end.wind + end.pins);
  json["dissipated"] = number_or_null(end.damped);
  add_momenta(report.momenta_start, report.momenta_end, json);
}

void add_parts(Json& json, const ClothWorld& world) {
  json["cloths"] = Json::array();
  for (std::size_t i = 0; i < world.cloths(); ++i)
    json["cloths"].push_back({{"cloth", world.scene().cloths[i].name},
                              {"particles", world.particles(i)},
                              {"springs", world.model(i).springs()},
                              {"triangles", world.triangles(i).size()},
                              {"joined", world.model(i).parts().joined}});
  json["balls"] = Json::array();
  for (std::size_t i = 0; i < world.balls().size(); ++i) {
    const ClothWorld::Ball& ball = world.balls()[i];
    json["balls"].push_back({{"ball", world.scene().balls[i].name},
                             {"position", vector_json(ball.position)},
                             {"velocity", vector_json(ball.velocity)},
                             {"spin", vector_json(ball.spin)}});
  }
}

Json cloth_json(const ClothFile& file, const ClothWorld& world, const ClothLog& log,
                const ClothEnding& ending) {
  const double step = file.scene.options.step, each = mean(ending.each);
  const auto steps = static_cast<double>(world.steps());
  Json json;
  json["schema"] = kReportSchema;
  json["scene"] = file.path;
  json["integrator"] = file.scene.integrator;
  json["step"] = step;
  json["duration"] = file.scene.duration;
  json["particles"] = all_particles(world);
  json["springs"] = all_springs(world);
  json["steps"] = world.steps();
  json["reached"] = world.time();
  json["microseconds_per_step"] = number_or_null(each);
  json["microseconds_per_step_median"] = number_or_null(median(ending.each));
  json["real_time_factor"] = number_or_null(1e6 * step / each);
  json["iterations_per_step"] = number_or_null(static_cast<double>(world.iterations()) / steps);
  json["cut_steps"] = world.cut_steps();
  json["stability_limit_s"] = number_or_null(world.stability_limit());
  json["penetration_max"] = number_or_null(world.penetration_max());
  add_energy_keys(json, log.report());
  add_parts(json, world);
  add_ending(ending, json);
  json["warnings"] = keyframe_warnings(file.scene);
  json["files"] = log.report().files;
  return json;
}

// Lists the files that a run of the scene writes.
RunOutputs cloth_outputs(const ClothFile& file) {
  const std::string& out = file.outputs.out;
  RunOutputs outputs;
  std::vector<std::string> names;
  for (const SceneCloth& cloth : file.scene.cloths) names.push_back(cloth.name);
  outputs.add_folder(out, names);
  outputs.add_files(out, {kReportName, kTableName, kEnergyPageName});
  outputs.add_files(out, names, {kFramesName});
  return outputs;
}

// Steps the world to the end of its time. A step that cannot be made and an energy that explodes
// end the run.
Result<ClothEnding> follow_cloths(const ClothFile& file, ClothWorld& world, ClothLog& log) {
  const Interruption interruption;
  ToldProgress progress(fs::path(file.path).stem().string(), file.scene.duration);
  const std::int64_t steps = std::llround(file.scene.duration / file.scene.options.step);
  ClothEnding ending;
  Result<bool> inside = log.observe(world);
  while (inside && *inside && world.steps() < steps && ending.signal == 0) {
    const double before = processor_time();
    const Status made = world.step();
    if (!made) {
      log.give_up(made.error());
      break;
    }
    ending.each.push_back(1e6 * (processor_time() - before));
    inside = log.observe(world);
    progress.reached(world.time());
    ending.interrupted(interruption.signal(), world.time());
  }
  if (!inside) return inside.error();
  if (log.report().exit_code != 0) {
    ending.exit_code = log.report().exit_code;
    ending.reason = log.report().reason;
  }
  return ending;
}

void tell_cloths(const ClothFile& file, const ClothWorld& world, const ClothLog& log,
                 const ClothEnding& ending) {
  const ClothReport& report = log.report();
  for (std::size_t i = 0; i < world.cloths(); ++i)
    if (const std::size_t joined = world.model(i).parts().joined; joined > 0)
      tell("cloth '{}': {} vertices of {} lie on others along seams and are joined with them\n",
           world.scene().cloths[i].name, joined, world.scene().cloths[i].file);
  tell("{}: {} particles reached {:.6g} of {:.6g} s by {} in steps of {:.4g} s, {:.2f} us each\n",
       fs::path(file.path).stem().string(), all_particles(world), world.time(), file.scene.duration,
       file.scene.integrator, file.scene.options.step, mean(ending.each));
  tell(
      "  energy {:.6g} -> {:.6g} J; wind {:.4g}, support {:.4g}, contact {:.4g}, damping {:.4g}, "
      "the method itself {:.4g} J\n",
      report.start.total(), report.end.total(), report.end.wind, report.end.pins,
      report.end.contact, -report.end.damped, report.end.numerical);
  if (std::isfinite(world.stability_limit()))
    tell("  stable up to steps of {:.4g} s\n", world.stability_limit());
  print_warnings(keyframe_warnings(file.scene));
  if (!report.files.empty())
    tell("  wrote into {}: {}\n", file.outputs.out, list_files(report.files));
}

Result<SceneRun> run_cloths(const ClothFile& file) {
  Result<ClothWorld> world = ClothWorld::create(file.scene);
  if (!world) return error_of_file(file.path, value_error(world.error()));
  Result<ClothLog> log = ClothLog::create(file, *world);
  if (!log) return log.error();
  Result<ClothEnding> ending = follow_cloths(file, *world, *log);
  if (!ending) return ending.error();
  if (Status s = log->finish(*world); !s) return s.error();
  tell_cloths(file, *world, *log, *ending);
  return SceneRun{cloth_json(file, *world, *log, *ending), *ending, log->report().files};
}

}  // namespace

std::vector<NamedFile> inputs_of(const ClothFile& file) {
  std::vector<NamedFile> inputs{{file.path, "the scene"}};
  for (const std::string& csv : file.files) inputs.push_back({csv, "a CSV file of the scene"});
  for (const SceneCloth& cloth : file.scene.cloths)
    if (!cloth.file.empty()) inputs.push_back({cloth.file, "a cloth's mesh", true});
  for (const SceneCollider& collider : file.scene.colliders)
    if (!collider.file.empty()) inputs.push_back({collider.file, "a collider file"});
  return inputs;
}

int run_cloth_command(const ClothFile& file, bool json) {
  return run_scene(inputs_of(file), cloth_outputs(file), file.outputs, json,
                   [&] { return run_cloths(file); });
}

namespace {

// Flags of bodies; a cloth has no modes, no loads, no probes and one thread.
constexpr const char* kOfBodies[] = {
    "--load",          "--frequency", "--sweep",         "--load-duration",
    "--signal",        "--at",        "--force",         "--scale",
    "--deflect",       "--start",     "--wav",           "--listen",
    "--modes",         "--linear",    "--hull",          "--rescale",
    "--alpha",         "--beta",      "--damping-ratio", "--newmark-beta",
    "--newmark-gamma", "--split",     "--safety",        "--coordinate",
    "--velocities",    "--probe",     "--save",          "--restore",
    "--threads",       "--degree"};

}  // namespace

Status apply_cloth_flags(const GivenFlags& flags, ClothFile& file) {
  for (const char* flag : kOfBodies)
    if (flags.given(flag))
      return usage_error(fmt::format(
          "{} applies only to bodies: a scene with [[cloths]] takes --integrator, --step, "
          "--duration, --tolerance, --max-iterations and flags of outputs",
          flag));
  const auto names = nodal_integrator_names();
  if (flags.given("--integrator")) {
    if (std::find(names.begin(), names.end(), flags.values.integrator) == names.end())
      return usage_error(fmt::format("--integrator: cloth has no method '{}'; there are {}",
                                     flags.values.integrator, fmt::join(names, ", ")));
    file.scene.integrator = flags.values.integrator;
  }
  NodalOptions& options = file.scene.options;
  if (flags.given("--step")) options.step = flags.values.step;
  if (flags.given("--tolerance")) options.tolerance = flags.values.tolerance;
  if (flags.given("--max-iterations")) options.max_iterations = flags.values.max_iterations;
  if (flags.given("--duration")) file.scene.duration = flags.values.duration;
  if (Status s = apply_output_flags(flags, file.outputs); !s) return s;
  if (Status s = check_times(flags, options.step, file.scene.duration); !s) return s;
  return check_scene(file.scene);
}

}  // namespace tremolo
