#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/program/cloth/run_cloth.h"
#include "runtime/program/world/scene_ending.h"

namespace tremolo {
namespace {

// Flags of reduced bodies; a cloth has no modes, no loads and no probes.
constexpr const char* kOfBodies[] = {
    "--load",       "--signal",     "--at",           "--force",         "--scale",  "--deflect",
    "--start",      "--wav",        "--listen",       "--modes",         "--linear", "--hull",
    "--alpha",      "--beta",       "--newmark-beta", "--newmark-gamma", "--split",  "--safety",
    "--coordinate", "--velocities", "--probe",        "--save",          "--restore"};

}  // namespace

Status apply_cloth_flags(const RunOptions& flags, const std::function<bool(const char*)>& given,
                         ClothFile& file) {
  for (const char* flag : kOfBodies)
    if (given(flag))
      return usage_error(fmt::format(
          "{} applies only to bodies: a scene with [[cloths]] takes --integrator, --step, "
          "--duration, --tolerance, --max-iterations and flags of outputs",
          flag));
  const auto names = nodal_integrator_names();
  if (given("--integrator")) {
    if (std::find(names.begin(), names.end(), flags.integrator) == names.end())
      return usage_error(fmt::format("--integrator: cloth has no method '{}'; there are {}",
                                     flags.integrator, fmt::join(names, ", ")));
    file.scene.integrator = flags.integrator;
  }
  NodalOptions& options = file.scene.options;
  if (given("--step")) options.step = flags.step;
  if (given("--tolerance")) options.tolerance = flags.tolerance;
  if (given("--max-iterations")) options.max_iterations = flags.max_iterations;
  if (given("--duration")) file.scene.duration = flags.duration;
  if (Status s = apply_output_flags(flags, given, file.outputs); !s) return s;
  if (Status s = check_times(given, options.step, file.scene.duration); !s) return s;
  return check_scene(file.scene);
}

}  // namespace tremolo
