
#include <fmt/format.h>

#include "runtime/program/tets/run_tets.h"
#include "runtime/program/world/scene_ending.h"

namespace tremolo {
namespace {

Status apply_tets_method(const RunOptions& flags, const std::string& degree,
                         const std::function<bool(const char*)>& given, TetBodyOptions& options) {
  if (given("--integrator"))
    if (Status s = take(options.method, parse_tet_method(flags.integrator)); !s) return s;
  if (given("--degree"))
    if (Status s = take(options.degree.kind, parse_degree(degree)); !s) return s;
  if (given("--alpha")) options.alpha = flags.alpha;
  if (given("--beta")) options.beta = flags.beta;
  if (given("--tolerance")) options.tolerance = flags.tolerance;
  if (given("--max-iterations")) options.max_iterations = flags.max_iterations;
  return Success{};
}

}  // namespace

Status apply_tets_flags(const RunOptions& flags, const std::string& degree,
                        const std::function<bool(const char*)>& given, TetScene& scene) {
  for (const char* flag :
       {"--load",         "--signal",        "--at",     "--force",  "--scale",  "--deflect",
        "--start",        "--wav",           "--listen", "--modes",  "--linear", "--hull",
        "--newmark-beta", "--newmark-gamma", "--split",  "--safety", "--probe",  "--coordinate",
        "--velocities",   "--plot",          "--save",   "--restore"})
    if (given(flag))
      return usage_error(fmt::format("{} does not apply to bodies of kind \"tets\"", flag));
  if (given("--step")) scene.step = flags.step;
  if (given("--duration")) scene.duration = flags.duration;
  if (Status s = apply_output_flags(flags, given, scene.outputs); !s) return s;
  if (Status s = check_times(given, scene.step, scene.duration); !s) return s;
  for (TetSceneBody& body : scene.bodies) {
    if (Status s = apply_tets_method(flags, degree, given, body.options); !s) return s;
    body.options.step = scene.step;
    if (Status s = check(body.options); !s) return s;
  }
  return Success{};
}

}  // namespace tremolo
