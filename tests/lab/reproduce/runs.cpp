#include "tests/lab/reproduce/runs.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "runtime/integrator.h"
#include "tests/lab/work/progress.h"

namespace tremolo::reproduce {
namespace {

using Json = nlohmann::json;

// Factors of the sine, so that `imexv` with its fixed split breaks off where the thesis's table 3
// says: beam at 6.86 s (7.12 s damped), tower at 10.53 s (damped it reaches 30 s). Found by runs of
// 30 s at 3 ms, tolerance 1e-6, at 300 factors (beam, 2.1 to 2.9) and 85 (tower, 2 to 3.2).
//   tower: undamped it breaks off from 2.1 on, damped from 2.19 on. Between 2.162 and 2.18 factors
//     give 8.8 to 12 s, below 12 to 27 s, above 4.9 to 10.3 s. The factor below gives 10.29 s.
//   beam: undamped it breaks off from 2.21 on, damped, now and then, from 2.61 on. Where the damped
//     run breaks off after 6 to 9 s the undamped one does after 1.8 to 3.2 s: no factor gives both
//     6.86 and 7.12 s. The factor below gives 2.73 and 6.46 s; 2.36 gives 7.35 s, and 30 s damped.
// The orbits are chaotic by then: a factor changed by 1e-6, or another compiler, moves the beam's
// times by a second or two, so they are what the table prints, not what is written here.
constexpr double kBeamSine = 2.6085;
constexpr double kTowerSine = 2.17;

constexpr int kOrbitVersion = 1;   // of run_orbit and its stored results
constexpr int kTimingVersion = 1;  // of time_orbit
constexpr int kRepetitions = 3;

const SampleModel& model_of(const Session& session, const RunName& run) {
  return *std::ranges::find(session.models, run.model, &SampleModel::name);
}

OrbitSpec spec_of(const Session& session, const RunName& run) {
  OrbitSpec spec;
  spec.model = model_of(session, run).model;
  spec.integrator = run.integrator;
  spec.load = run.load;
  spec.alpha = run.alpha;
  spec.scale = run.load_multiple * load_factor(run.model, run.load);
  spec.step = run.step;
  spec.duration = run.duration;
  return spec;
}

Json key_of(const Session& session, const RunName& run) {
  return {{"program", session.program},
          {"model", model_of(session, run).checksum},
          {"run", run.text()},
          {"scale", run.load_multiple * load_factor(run.model, run.load)},
          {"tolerance", kTolerance}};
}

Orbit one_orbit(const Session& session, const RunName& run) {
  Json key = key_of(session, run);
  key["version"] = kOrbitVersion;
  return session.store.get_as<Orbit>("orbit-" + run.text(), key,
                                     [&] { return run_orbit(spec_of(session, run)); });
}

// Seconds of each of `names`, the smallest of several rounds.
Json seconds_by_turns(const Session& session, const std::vector<RunName>& names,
                      const std::vector<std::int64_t>& steps) {
  std::vector<double> best(names.size(), std::numeric_limits<double>::infinity());
  for (int turn = 0; turn < kRepetitions; ++turn)
    for (std::size_t i = 0; i < names.size(); ++i)
      best[i] = std::min(best[i], time_orbit(spec_of(session, names[i]), steps[i]));
  return best;
}

}  // namespace

double load_factor(std::string_view model, SignalKind load) {
  if (load != SignalKind::kSine) return 1.0;
  if (model == "beam") return kBeamSine;
  return model == "tower" ? kTowerSine : 1.0;
}

std::string RunName::text() const {
  std::string name =
      fmt::format("{}-{}-a{:g}-{}", model, thesis::load_name(load), alpha, integrator);
  if (load_multiple != 1.0) name += fmt::format("-x{:g}", load_multiple);
  if (step != thesis::kStep) name += fmt::format("-h{:g}ms", 1e3 * step);
  if (duration != thesis::kDuration) name += fmt::format("-{:g}s", duration);
  return name;
}

std::vector<RunName> thesis_runs(const std::vector<SampleModel>& models,
                                 const std::string& integrator, double load_multiple) {
  std::vector<RunName> runs;
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads)
      for (const SampleModel& model : models)
        runs.push_back({model.name, integrator, load, alpha, load_multiple});
  return runs;
}

Orbits run_all(const Session& session, const std::vector<RunName>& runs, const std::string& what) {
  std::vector<Orbit> made(runs.size());
  for_all(what, runs.size(), session.threads,
          [&](std::size_t i) { made[i] = one_orbit(session, runs[i]); });
  Orbits orbits;
  for (std::size_t i = 0; i < runs.size(); ++i) orbits.emplace(runs[i].text(), std::move(made[i]));
  return orbits;
}

Timings time_all(const Session& session, const Orbits& orbits) {
  const std::vector<RunName> runs = thesis_runs(session.models, "all");
  Timings timings;
  for_all("timings", runs.size(), 1, [&](std::size_t k) {
    std::vector<RunName> names;
    std::vector<std::int64_t> steps;
    for (const std::string method : kMethods) {
      names.push_back(runs[k]);
      names.back().integrator = method;
      steps.push_back(orbits.at(names.back().text()).steps);
    }
    Json key = key_of(session, runs[k]);
    key["version"] = kTimingVersion;
    key["steps"] = steps;
    key["methods"] = kMethods;
    const Json seconds = session.store.get("timing-" + runs[k].text(), key,
                                           [&] { return seconds_by_turns(session, names, steps); });
    for (std::size_t i = 0; i < names.size(); ++i)
      timings[names[i].text()] = {seconds.at(i).get<double>(), steps[i]};
  });
  return timings;
}

}  // namespace tremolo::reproduce
