#include "tests/lab/bench/stability.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/program/output/progress.h"
#include "tests/lab/bench/measure.h"

namespace tremolo::bench {
namespace {

using Json = nlohmann::json;

constexpr double kSeen = 30e-3;  // s, from one look at the energy to the next

// The multiple of the step next to kSeen.
double sample_of(double step) {
  return step * std::max(1.0, std::round(kSeen / step));
}

Outcome outcome_of(const SampledRun& run) {
  if (run.exit_code != 0) return Outcome::kDies;
  if (run.drift <= kSurvives) return Outcome::kSurvives;
  return run.energy_end < run.energy_reference ? Outcome::kDecays : Outcome::kGrows;
}

Result<Json> run_grid(const Subject& subject, const std::string& integrator,
                      const Options& options) {
  Json cells = Json::array();
  for (const double scale : options.stability_scales)
    for (const double ms : options.stability_steps_ms) {
      Scene scene{&subject, "square", 0.0, options.stability_duration, scale, ""};
      RunSpec spec = scene.run(integrator, 1e-3 * ms);
      spec.sample = sample_of(spec.options.step);
      Result<SampledRun> run = run_sampled(spec);
      if (!run) return run.error();
      cells.push_back({{"scale", scale},
                       {"step", spec.options.step},
                       {"outcome", static_cast<int>(outcome_of(*run))},
                       {"reached", run->reached},
                       {"drift", run->drift},
                       {"reason", run->reason}});
    }
  return cells;
}

}  // namespace

const char* name_of(Outcome outcome) {
  constexpr const char* kNames[] = {"survives", "grows", "decays", "dies"};
  return kNames[static_cast<int>(outcome)];
}

Result<std::vector<StabilityCell>> measure_stability(const Options& options,
                                                     const std::vector<Subject>& subjects,
                                                     const Store& store) {
  const std::size_t methods = options.integrators.size();
  std::vector<std::vector<StabilityCell>> grids(subjects.size() * methods);
  const auto work = [&](std::size_t k) -> Status {
    const Subject& subject = subjects[k / methods];
    const std::string& integrator = options.integrators[k % methods];
    const Scene probe{&subject, "square", 0.0, 1.0, options.stability_scales.back(), ""};
    Result<std::string> print =
        fingerprint(probe, integrator, 1e-3 * options.stability_steps_ms.back());
    if (!print) return print.error();
    const Json key = {
        {"model", subject.sample.checksum},       {"integrator", integrator},
        {"scales", options.stability_scales},     {"steps", options.stability_steps_ms},
        {"duration", options.stability_duration}, {"fingerprint", *print}};
    Result<Json> json = store.get("stability-" + subject.sample.name + "-" + integrator, key,
                                  [&] { return run_grid(subject, integrator, options); });
    if (!json) return json.error();
    for (const Json& cell : *json)
      grids[k].push_back({subject.sample.name, integrator, cell.at("scale"), cell.at("step"),
                          static_cast<Outcome>(cell.at("outcome").get<int>()), cell.at("reached"),
                          cell.at("drift").is_number() ? cell.at("drift").get<double>()
                                                       : std::numeric_limits<double>::quiet_NaN(),
                          cell.at("reason")});
    return Success{};
  };
  Status status = for_all("stability", grids.size(), thread_count(options.threads), work);
  if (!status) return status.error();
  std::vector<StabilityCell> cells;
  for (const auto& grid : grids) cells.insert(cells.end(), grid.begin(), grid.end());
  return cells;
}

}  // namespace tremolo::bench
