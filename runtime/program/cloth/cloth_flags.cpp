#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/program/cloth/run_cloth.h"

namespace tremolo {
namespace {

// Of reduced bodies; a cloth has no modes, no loads and no probes.
constexpr const char* kOfBodies[] = {
    "--load",       "--signal",     "--at",           "--force",         "--scale",  "--deflect",
    "--start",      "--wav",        "--listen",       "--modes",         "--linear", "--hull",
    "--alpha",      "--beta",       "--newmark-beta", "--newmark-gamma", "--split",  "--safety",
    "--coordinate", "--velocities", "--probe",        "--save",          "--restore"};

Status check_cloth_outputs(const SceneOutputs& outputs) {
  if ((outputs.surfaces > 0 || outputs.plot) && outputs.out.empty())
    return usage_error("--surfaces and --plot need --out DIR");
  if (outputs.every < 1) return content_error("--every must be at least 1");
  if (outputs.surfaces < 0) return content_error("--surfaces must not be negative");
  return Success{};
}

}  // namespace

Status apply_cloth_flags(const RunOptions& flags, const std::function<bool(const char*)>& told,
                         ClothFile& file) {
  for (const char* flag : kOfBodies)
    if (told(flag))
      return usage_error(
          fmt::format("{} is of bodies: a scene with [[cloths]] takes --integrator, --step, "
                      "--duration, --tolerance, --max-iterations and what is written",
                      flag));
  const auto names = nodal_integrator_names();
  if (told("--integrator")) {
    if (std::find(names.begin(), names.end(), flags.integrator) == names.end())
      return usage_error(fmt::format("--integrator: '{}' is none of cloth's: {}", flags.integrator,
                                     fmt::join(names, ", ")));
    file.scene.integrator = flags.integrator;
  }
  NodalOptions& options = file.scene.options;
  if (told("--step")) options.step = flags.step;
  if (told("--tolerance")) options.tolerance = flags.tolerance;
  if (told("--max-iterations")) options.max_iterations = flags.max_iterations;
  if (told("--duration")) file.scene.duration = flags.duration;
  SceneOutputs& outputs = file.outputs;
  if (told("--out")) outputs.out = flags.out;
  if (told("--every")) outputs.every = flags.every;
  if (told("--surfaces")) outputs.surfaces = flags.surfaces;
  if (told("--surface-format")) outputs.surface_format = flags.surface_format;
  if (told("--plot")) outputs.plot = flags.plot;
  if (Status s = check_cloth_outputs(outputs); !s) return s;
  for (const auto& [flag, value] :
       {std::pair{"--step", options.step}, {"--duration", file.scene.duration}})
    if (told(flag) && !(value > 0.0 && std::isfinite(value)))
      return content_error(fmt::format("{} must be positive and finite (s)", flag));
  return check_scene(file.scene);
}

}  // namespace tremolo
