#include "runtime/apps/tremolo/run/body_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/damping_ratios.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/sound.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/io/scenes/csv_rows.h"

namespace tremolo {
namespace {

Status check_combinations(const RunOptions& options) {
  if ((options.surfaces > 0 || options.plot) && options.out.empty())
    return usage_error("--surfaces and --plot need --out DIR");
  if (options.at.empty() != options.force.empty())
    return usage_error("--at and --force belong together");
  if (options.velocities && options.coordinates.empty() && options.probes.empty())
    return usage_error("--velocities are those of --coordinate and --probe: name some");
  if (options.deflect.empty()) return Success{};
  if (options.scale != 1.0)
    return usage_error("--deflect finds the load's factor: leave --scale out");
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
  if (options.every < 1) return content_error("--every must be at least 1");
  if (options.surfaces < 0) return content_error("--surfaces must not be negative");
  if (!std::isfinite(options.scale)) return content_error("--scale must be finite");
  if (Status status = check_sound(options.wav, options.step); !status) return status;
  return check_combinations(options);
}

Result<IntegratorOptions> integrator_options(const RunOptions& options) {
  IntegratorOptions settings;
  settings.alpha = options.alpha;
  settings.beta = options.beta;
  if (!options.damping_ratio.empty()) {
    const Result<DampingRatios> damping = parse_damping(options.damping_ratio);
    if (!damping) return damping.error();
    put_damping(*damping, settings);
  }
  settings.newmark_beta = options.newmark_beta;
  settings.newmark_gamma = options.newmark_gamma;
  settings.tolerance = options.tolerance;
  settings.max_iterations = options.max_iterations;
  if (Status s = take(settings.split, parse_split(options.split)); !s) return s.error();
  settings.split.safety = options.safety;
  return settings;
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

SceneOutputs scene_outputs(const RunOptions& options) {
  SceneOutputs outputs;
  outputs.out = options.out;
  outputs.every = options.every;
  outputs.surfaces = options.surfaces;
  outputs.surface_format = options.surface_format;
  outputs.plot = options.plot;
  outputs.wav = options.wav;
  outputs.listen = options.listen;
  outputs.sound_steps = options.sound_steps;
  return outputs;
}

}  // namespace

IntegratorOptions BodyScene::settings() const {
  IntegratorOptions settings = body().options;
  settings.step = step();
  return settings;
}

Result<BodyScene> body_scene(const RunOptions& options) {
  if (Status s = check_values(options); !s) return s.error();
  SceneBody body;
  body.name =
      options.name.empty() ? std::filesystem::path(options.model).stem().string() : options.name;
  body.model = options.model;
  body.model_options = {options.modes, options.linear, options.hull};
  body.integrator = options.integrator;
  body.columns = {options.probes, options.coordinates, options.velocities};
  if (Status s = take(body.options, integrator_options(options)); !s) return s.error();
  Result<SceneLoad> load = load_of(options);
  if (!load) return load.error();
  body.loads.push_back(std::move(*load));
  BodyScene scene;
  scene.file.path = options.scene;
  scene.file.scene.step = options.step;
  scene.file.scene.duration = options.duration;
  scene.file.scene.bodies.push_back(std::move(body));
  scene.file.outputs = scene_outputs(options);
  if (!options.signal.empty()) scene.file.files.push_back(options.signal);
  scene.load_name = options.signal.empty() ? options.load : options.signal;
  scene.deflect = options.deflect;
  scene.start = options.start;
  scene.rescale = options.rescale;
  return scene;
}

}  // namespace tremolo
