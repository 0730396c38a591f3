#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/integrator.h"

namespace tremolo {

Status apply_flags(const GivenFlags& flags, SceneFile& file) {
  for (const char* flag : {"--load", "--signal", "--at", "--force", "--scale", "--deflect",
                           "--start", "--frequency", "--sweep", "--load-duration", "--rescale"})
    if (flags.given(flag))
      return usage_error(fmt::format(
          "{} applies only to one body: set it in the scene, where {} has its own table", flag,
          file.scene.bodies.size() == 1 ? "the body" : "each body"));
  const auto names = integrator_names();
  if (flags.given("--integrator") &&
      std::find(names.begin(), names.end(), flags.values.integrator) == names.end())
    return usage_error(fmt::format("--integrator: unknown integrator '{}'; there are {}",
                                   flags.values.integrator, fmt::join(names, ", ")));
  const auto is_rigid = [](const SceneBody& body) { return body.rigid.has_value(); };
  const bool all_rigid = std::ranges::all_of(file.scene.bodies, is_rigid);
  for (SceneBody& body : file.scene.bodies) {
    const IntegratorOptions own = body.options;
    if (Status s = apply_to_body(flags, body); !s) return s;
    // Nothing of a rigid body moves relative to its frame: damping is that of the others.
    if (!is_rigid(body) || all_rigid) continue;
    body.options.alpha = own.alpha;
    body.options.beta = own.beta;
    body.options.ratios = own.ratios;
  }
  if (flags.given("--step")) file.scene.step = flags.values.step;
  if (flags.given("--duration")) file.scene.duration = flags.values.duration;
  SceneOutputs& outputs = file.outputs;
  if (flags.given("--wav")) outputs.wav = flags.values.wav;
  if (flags.given("--listen")) outputs.listen = flags.values.listen;
  if (!outputs.wav.empty() && !flags.given("--step")) {
    file.scene.step = kSoundStep;
    outputs.sound_steps = 0;
  }
  if (Status s = check_sound(outputs.wav, outputs.listen, file.scene.step); !s) return s;
  if (Status s = apply_output_flags(flags, outputs); !s) return s;
  if (Status s = check_times(flags, file.scene.step, file.scene.duration); !s) return s;
  return check_scene(file.scene);
}

Status apply_flags(const GivenFlags& flags, MixedFile& mixed) {
  if (mixed.has_guests())
    for (const char* flag : {"--integrator", "--alpha", "--beta", "--damping-ratio", "--tolerance",
                             "--max-iterations"})
      if (flags.given(flag))
        return usage_error(
            fmt::format("{}: bodies of {} and the others have methods of their own: set it in the "
                        "scene",
                        flag, mixed.tets.empty() ? "cloth" : "tetrahedra"));
  if (Status s = apply_flags(flags, mixed.file); !s) return s;
  if (flags.given("--probe")) {
    for (TetSceneBody& body : mixed.tets) body.probes = flags.values.probes;
    for (ClothSceneBody& body : mixed.cloths) body.probes = flags.values.probes;
  }
  mixed.set_guest_step(mixed.file.scene.step);
  return Success{};
}

}  // namespace tremolo
