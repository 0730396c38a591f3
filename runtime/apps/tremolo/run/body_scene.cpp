#include "runtime/apps/tremolo/run/body_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/damping_ratios.h"
#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/split.h"

namespace tremolo {
namespace {

Status check_combinations(const RunOptions& options) {
  if (options.at.empty() != options.force.empty())
    return usage_error("--at and --force belong together");
  if (options.velocities && options.coordinates.empty() && options.probes.empty())
    return usage_error("--velocities are those of --coordinate and --probe: name some");
  if (options.deflect.empty()) return Success{};
  if (options.scale != 1.0)
    return usage_error("--deflect finds the load's factor: leave --scale out");
  if (!options.restore.empty())
    return usage_error(
        "--deflect finds the load's factor for a whole run: with --restore give the factor by "
        "--scale");
  if (options.load == "none" && options.signal.empty())
    return usage_error("--deflect scales a load: there is none");
  if (!options.start.empty() && options.start != kStaticStart)
    return usage_error("--deflect scales a load: with --start it works from `static` alone");
  const Result<double> share = parse_share(options.deflect);
  return share ? Status(Success{}) : Status(share.error());
}

Status check_values(const RunOptions& options) {
  const auto names = integrator_names();
  if (std::find(names.begin(), names.end(), options.integrator) == names.end())
    return usage_error(fmt::format("unknown integrator '{}'; there are {}", options.integrator,
                                   fmt::join(names, ", ")));
  if (!(options.duration > 0) || !std::isfinite(options.duration))
    return content_error("--duration must be positive and finite (s)");
  if (!(options.step > 0) || !std::isfinite(options.step))
    return content_error("--step must be positive and finite (s)");
  if (options.duration / options.step > 1e12)
    return content_error("--duration and --step ask for more than 1e12 steps");
  if (options.duration < 0.5 * options.step)
    return content_error("--duration is shorter than half a step: nothing would be done");
  const std::string& format = options.surface_format;
  if (format != "ply" && format != "obj" && format != "inc")
    return usage_error("surface-format '" + format + "': must be ply, obj or inc");
  if (!std::isfinite(options.scale)) return content_error("--scale must be finite");
  if (Status status = check_sound(options.wav, options.listen, options.step); !status)
    return status;
  return check_combinations(options);
}

// Its course in time.
Status shape_load(const RunOptions& options, SceneLoad& load) {
  if (!options.signal.empty()) {
    Result<SignalTable> table = read_signal(options.signal);
    if (!table) return table.error();
    load.table = std::make_shared<const SignalTable>(std::move(*table));
    load.signal = {.kind = SignalKind::kTable};
    return shape_signal(options.shape, load.signal);
  }
  if (Status s = take(load.signal, parse_signal(options.load)); !s) return s;
  if (Status s = shape_signal(options.shape, load.signal); !s) return s;
  // Without a duration of their own they take the whole run.
  const SignalKind kind = load.signal.kind;
  const bool slow = kind == SignalKind::kChirp || kind == SignalKind::kRamp;
  if (slow && !options.shape.duration) load.signal.duration = options.duration;
  return Success{};
}

Result<SceneLoad> load_of(const RunOptions& options) {
  SceneLoad load;
  load.at = options.at;
  load.scale = options.scale;
  if (Status s = shape_load(options, load); !s) return s.error();
  if (load.signal.kind == SignalKind::kNone || options.force.empty()) return load;
  if (Status s = take(load.force, parse_force(options.force)); !s) return s.error();
  return load;
}

}  // namespace

Status apply_to_body(const GivenFlags& flags, SceneBody& body) {
  IntegratorOptions& options = body.options;
  if (flags.given("--integrator")) body.integrator = flags.values.integrator;
  if (flags.given("--modes")) body.model_options.modes = flags.values.modes;
  if (flags.given("--linear")) body.model_options.linear = flags.values.linear;
  if (flags.given("--hull")) body.model_options.hull = flags.values.hull;
  if (flags.given("--alpha") || flags.given("--beta")) options.ratios = {};
  if (flags.given("--alpha")) {
    options.alpha = flags.values.alpha;
    body.alphas.clear();
  }
  if (flags.given("--beta")) {
    options.beta = flags.values.beta;
    body.betas.clear();
  }
  if (flags.given("--damping-ratio")) {
    const Result<DampingRatios> damping = parse_damping(flags.values.damping_ratio);
    if (!damping) return damping.error();
    put_damping(*damping, options);
    body.alphas.clear();
    body.betas.clear();
  }
  if (flags.given("--newmark-beta")) options.newmark_beta = flags.values.newmark_beta;
  if (flags.given("--newmark-gamma")) options.newmark_gamma = flags.values.newmark_gamma;
  if (flags.given("--tolerance")) options.tolerance = flags.values.tolerance;
  if (flags.given("--max-iterations")) options.max_iterations = flags.values.max_iterations;
  if (flags.given("--probe")) body.columns.probes = flags.values.probes;
  if (flags.given("--coordinate")) body.columns.coordinates = flags.values.coordinates;
  if (flags.given("--velocities")) body.columns.velocities = flags.values.velocities;
  if (flags.given("--split")) {
    const double safety = options.split.safety;
    if (Status s = take(options.split, parse_split(flags.values.split)); !s) return s;
    options.split.safety = safety;
  }
  if (flags.given("--safety")) options.split.safety = flags.values.safety;
  return Success{};
}

IntegratorOptions BodyScene::settings() const {
  IntegratorOptions settings = body().options;
  settings.step = step();
  return settings;
}

Result<BodyScene> body_scene(const RunOptions& options) {
  BodyScene scene;
  scene.file.path = options.scene;
  scene.file.scene.step = options.step;
  scene.file.scene.duration = options.duration;
  scene.load_name = options.signal.empty() ? options.load : options.signal;
  scene.deflect = options.deflect;
  scene.start = options.start;
  scene.rescale = options.rescale;
  if (!options.signal.empty()) scene.file.files.push_back(options.signal);
  SceneOutputs& outputs = scene.file.outputs;
  outputs.wav = options.wav;
  outputs.listen = options.listen;
  outputs.sound_steps = options.sound_steps;
  if (Status s = check_values(options); !s) return s.error();
  // Each of them has a value, be it the usual one; a text of damping ratios replaces alpha and
  // beta.
  const GivenFlags flags{options, [&options](std::string_view flag) {
                           return flag != "--damping-ratio" || !options.damping_ratio.empty();
                         }};
  if (Status s = apply_output_flags(flags, outputs); !s) return s.error();
  SceneBody& body = scene.file.scene.bodies.emplace_back();
  body.name =
      options.name.empty() ? std::filesystem::path(options.model).stem().string() : options.name;
  body.model = options.model;
  if (Status s = apply_to_body(flags, body); !s) return s.error();
  Result<SceneLoad> load = load_of(options);
  if (!load) return load.error();
  body.loads.push_back(std::move(*load));
  return scene;
}

Result<std::vector<BodyScene>> body_scenes(std::vector<RunOptions> tables, const GivenFlags& flags,
                                           const std::string& path) {
  std::vector<BodyScene> scenes;
  for (RunOptions& body : tables) {
    put_over(flags, body);
    for (const auto& [flag, file] :
         {std::pair{"--wav", &body.wav}, {"--save", &body.save}, {"--restore", &body.restore}})
      if (!file->empty() && tables.size() > 1)
        return usage_error(std::string(flag) + " applies only to one body, and " + path +
                           " has several");
    if (tables.size() > 1 && !body.out.empty())
      body.out = (std::filesystem::path(body.out) / body.name).string();
    Result<BodyScene> scene = body_scene(body);
    if (!scene) return scene.error();
    scenes.push_back(std::move(*scene));
  }
  return scenes;
}

Result<std::vector<BodyScene>> body_scenes(const std::string& text, const GivenFlags& flags,
                                           const std::string& path) {
  Result<std::vector<RunOptions>> tables = parse_scene(text, path);
  if (!tables) return tables.error();
  return body_scenes(std::move(*tables), flags, path);
}

Result<std::vector<BodyScene>> model_scene(const std::string& path, const GivenFlags& flags) {
  RunOptions body;
  body.model = path;
  return body_scenes({std::move(body)}, flags, path);
}

}  // namespace tremolo
