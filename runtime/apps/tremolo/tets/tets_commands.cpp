#include "runtime/apps/tremolo/tets/tets_commands.h"

#include <fmt/format.h>

#include "runtime/apps/tremolo/measure/tets_log.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/scene_ending.h"

namespace tremolo {
namespace {

Result<ScenePlaces> places_of(const TetScene& scene) {
  const Result<TetsBodies> bodies = make_tets_bodies(scene);
  if (!bodies) return error_of_file(scene.path, value_error(bodies.error()));
  ScenePlaces places{scene.path, "a world of tetrahedra", scene.step, scene.duration, true, {}, {},
                     {}};
  places.warnings = keyframe_warnings({}, scene.colliders);
  for (std::size_t i = 0; i < bodies->group->size(); ++i)
    places.bodies.push_back(
        placed_tets(scene.bodies[i], *bodies->kind(i).surface, bodies->group->body(i)));
  for (const SceneCollider& collider : scene.colliders)
    places.colliders.push_back({collider.name, collider.shape, collider.pose});
  return places;
}

}  // namespace

int inspect_tets_command(const TetScene& scene, bool json) {
  const Result<ScenePlaces> places = places_of(scene);
  if (!places) return report_error(places.error());
  print_places(*places, json);
  return 0;
}

namespace {

Status apply_tets_method(const GivenFlags& flags, const std::string& degree,
                         TetBodyOptions& options) {
  if (flags.given("--integrator"))
    if (Status s = take(options.method, parse_tet_method(flags.values.integrator)); !s) return s;
  if (flags.given("--degree"))
    if (Status s = take(options.degree.kind, parse_degree(degree)); !s) return s;
  if (flags.given("--alpha")) options.alpha = flags.values.alpha;
  if (flags.given("--beta")) options.beta = flags.values.beta;
  if (flags.given("--tolerance")) options.tolerance = flags.values.tolerance;
  if (flags.given("--max-iterations")) options.max_iterations = flags.values.max_iterations;
  return Success{};
}

}  // namespace

Status apply_tets_flags(const GivenFlags& flags, const std::string& degree, TetScene& scene) {
  for (const char* flag :
       {"--load",    "--frequency",     "--sweep",        "--load-duration", "--signal",
        "--at",      "--force",         "--scale",        "--deflect",       "--start",
        "--wav",     "--listen",        "--modes",        "--linear",        "--hull",
        "--rescale", "--damping-ratio", "--newmark-beta", "--newmark-gamma", "--split",
        "--safety",  "--probe",         "--coordinate",   "--velocities",    "--plot",
        "--save",    "--restore"})
    if (flags.given(flag))
      return usage_error(fmt::format(
          "{} does not apply to bodies of kind \"tets\": they take --integrator, --degree, "
          "--alpha, --beta, --tolerance, --max-iterations, --step, --duration and flags "
          "of outputs",
          flag));
  if (flags.given("--threads"))
    return usage_error(
        "--threads does not apply to bodies of kind \"tets\": set `threads` in the scene");
  if (flags.given("--step")) scene.step = flags.values.step;
  if (flags.given("--duration")) scene.duration = flags.values.duration;
  if (Status s = apply_output_flags(flags, scene.outputs); !s) return s;
  if (Status s = check_times(flags, scene.step, scene.duration); !s) return s;
  for (TetSceneBody& body : scene.bodies) {
    if (Status s = apply_tets_method(flags, degree, body.options); !s) return s;
    body.options.step = scene.step;
    if (Status s = check(body.options); !s) return s;
  }
  return Success{};
}

}  // namespace tremolo
