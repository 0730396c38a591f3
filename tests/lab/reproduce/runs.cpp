#include "tests/lab/reproduce/runs.h"

#include <algorithm>

#include <fmt/format.h>

#include "runtime/integrator.h"
#include "runtime/program/output/progress.h"
#include "tests/lab/reproduce/loads.h"
#include "tests/lab/samples/thesis.h"

namespace tremolo::reproduce {
namespace {

using Json = nlohmann::json;

constexpr int kOrbitVersion = 1;   // of watch_orbit and what it stores
constexpr int kTimingVersion = 1;  // of time_orbit
constexpr int kRepetitions = 3;

const SampleModel& model_of(const Workshop& shop, const RunName& run) {
  return *std::ranges::find(shop.models, run.model, &SampleModel::name);
}

OrbitSpec spec_of(const Workshop& shop, const RunName& run) {
  OrbitSpec spec;
  spec.model = model_of(shop, run).model;
  spec.integrator = run.integrator;
  spec.load = run.load;
  spec.alpha = run.alpha;
  spec.scale = run.another * load_factor(run.model, run.load);
  spec.step = run.step;
  spec.duration = run.duration;
  return spec;
}

Json key_of(const Workshop& shop, const RunName& run) {
  return {{"program", shop.program},
          {"model", model_of(shop, run).checksum},
          {"run", run.text()},
          {"scale", run.another * load_factor(run.model, run.load)},
          {"tolerance", kTolerance}};
}

Result<Orbit> one_orbit(const Workshop& shop, const RunName& run) {
  Json key = key_of(shop, run);
  key["version"] = kOrbitVersion;
  Result<Json> json = shop.store.get("orbit-" + run.text(), key, [&]() -> Result<Json> {
    Result<Orbit> orbit = watch_orbit(spec_of(shop, run));
    if (!orbit) return orbit.error();
    return to_json(*orbit);
  });
  if (!json) return json.error();
  return orbit_from_json(*json);
}

// Seconds of each of `names`, the smallest of several turns.
Result<Json> time_by_turns(const Workshop& shop, const std::vector<RunName>& names,
                           const std::vector<std::int64_t>& steps) {
  std::vector<double> best(names.size(), 0.0);
  for (int turn = 0; turn < kRepetitions; ++turn)
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Result<double> seconds = time_orbit(spec_of(shop, names[i]), steps[i]);
      if (!seconds) return seconds.error();
      best[i] = turn == 0 ? *seconds : std::min(best[i], *seconds);
    }
  return Json(best);
}

}  // namespace

std::string RunName::text() const {
  std::string name =
      fmt::format("{}-{}-a{:g}-{}", model, thesis::load_name(load), alpha, integrator);
  if (another != 1.0) name += fmt::format("-x{:g}", another);
  if (step != thesis::kStep) name += fmt::format("-h{:g}ms", 1e3 * step);
  if (duration != thesis::kDuration) name += fmt::format("-{:g}s", duration);
  return name;
}

std::vector<RunName> the_runs(const std::vector<SampleModel>& models, const std::string& integrator,
                              double another) {
  std::vector<RunName> runs;
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads)
      for (const SampleModel& model : models)
        runs.push_back({model.name, integrator, load, alpha, another});
  return runs;
}

Result<Orbits> watch_all(const Workshop& shop, const std::vector<RunName>& runs,
                         const std::string& what) {
  std::vector<Orbit> made(runs.size());
  Status status = for_all(what.c_str(), runs.size(), shop.threads, [&](std::size_t i) -> Status {
    Result<Orbit> orbit = one_orbit(shop, runs[i]);
    if (!orbit) return orbit.error();
    made[i] = std::move(*orbit);
    return Success{};
  });
  if (!status) return status.error();
  Orbits orbits;
  for (std::size_t i = 0; i < runs.size(); ++i) orbits.emplace(runs[i].text(), std::move(made[i]));
  return orbits;
}

Result<Timings> time_all(const Workshop& shop, const Orbits& orbits) {
  const std::vector<RunName> runs = the_runs(shop.models, "all");
  Timings timings;
  Status status = for_all("timings", runs.size(), 1, [&](std::size_t k) -> Status {
    const RunName& run = runs[k];
    std::vector<RunName> names;
    std::vector<std::int64_t> steps;
    for (const std::string method : kMethods) {
      names.push_back(run);
      names.back().integrator = method;
      steps.push_back(orbits.at(names.back().text()).steps);
    }
    Json key = key_of(shop, run);
    key["version"] = kTimingVersion;
    key["steps"] = steps;
    key["methods"] = kMethods;
    Result<Json> seconds = shop.store.get("timing-" + run.text(), key,
                                          [&] { return time_by_turns(shop, names, steps); });
    if (!seconds) return seconds.error();
    for (std::size_t i = 0; i < names.size(); ++i)
      timings[names[i].text()] = {seconds->at(i).get<double>(), steps[i]};
    return Success{};
  });
  if (!status) return status.error();
  return timings;
}

}  // namespace tremolo::reproduce
