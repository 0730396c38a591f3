#include "tests/lab/bench/stability.h"

#include <cmath>

#include <fmt/format.h>

#include "tests/lab/bench/measure.h"
#include "tests/lab/work/progress.h"

namespace tremolo::bench {

// The stored data of a cell.
template <class Archive>
void fields(Archive& archive, StabilityCell& cell) {
  archive("scale", cell.scale, "step", cell.step, "outcome", cell.outcome, "reached", cell.reached,
          "drift", cell.drift, "reason", cell.reason);
}

namespace {

using Json = nlohmann::json;

constexpr double kSampleInterval = 30e-3;  // s, requested between two samples of the energy

// The multiple of the step next to kSampleInterval.
double sample_of(double step) {
  return step * std::max(1.0, std::round(kSampleInterval / step));
}

Outcome outcome_of(const SampledRun& run) {
  if (run.exit_code != 0) return Outcome::kDies;
  if (run.drift <= kSurvives) return Outcome::kSurvives;
  return run.energy_end < run.energy_reference ? Outcome::kDecays : Outcome::kGrows;
}

std::vector<StabilityCell> run_grid(const Subject& subject, const std::string& integrator,
                                    const Options& options) {
  std::vector<StabilityCell> cells;
  for (const double scale : options.stability_scales)
    for (const double ms : options.stability_steps_ms) {
      Scene scene{&subject, "square", 0.0, options.stability_duration, scale, ""};
      RunSpec spec = scene.run(integrator, 1e-3 * ms);
      spec.sample = sample_of(spec.options.step);
      const SampledRun run = run_sampled(spec);
      cells.push_back({.scale = scale,
                       .step = spec.options.step,
                       .outcome = outcome_of(run),
                       .reached = run.reached,
                       .drift = run.drift,
                       .reason = run.reason});
    }
  return cells;
}

// The same from the store, with model and integrator.
std::vector<StabilityCell> stored_grid(const Subject& subject, const std::string& integrator,
                                       const Options& options, const Store& store) {
  const Scene probe{&subject, "square", 0.0, 1.0, options.stability_scales.back(), ""};
  const Json key = {
      {"model", subject.sample.checksum},
      {"integrator", integrator},
      {"scales", options.stability_scales},
      {"steps", options.stability_steps_ms},
      {"duration", options.stability_duration},
      {"fingerprint", fingerprint(probe, integrator, 1e-3 * options.stability_steps_ms.back())}};
  const Json stored = store.get("stability-" + subject.sample.name + "-" + integrator, key, [&] {
    Json cells = Json::array();
    for (const StabilityCell& cell : run_grid(subject, integrator, options))
      cells.push_back(fields_to_json(cell));
    return cells;
  });
  std::vector<StabilityCell> cells;
  for (const Json& one : stored) {
    cells.push_back(fields_from_json<StabilityCell>(one));
    cells.back().model = subject.sample.name;
    cells.back().integrator = integrator;
  }
  return cells;
}

}  // namespace

const char* name_of(Outcome outcome) {
  constexpr const char* kNames[] = {"survives", "grows", "decays", "dies"};
  return kNames[static_cast<int>(outcome)];
}

std::vector<StabilityCell> measure_stability(const Options& options,
                                             const std::vector<Subject>& subjects,
                                             const Store& store) {
  const std::size_t methods = options.integrators.size();
  std::vector<std::vector<StabilityCell>> grids(subjects.size() * methods);
  for_all("stability", grids.size(), thread_count(options.threads), [&](std::size_t k) {
    grids[k] = stored_grid(subjects[k / methods], options.integrators[k % methods], options, store);
  });
  std::vector<StabilityCell> cells;
  for (const auto& grid : grids) cells.insert(cells.end(), grid.begin(), grid.end());
  return cells;
}

}  // namespace tremolo::bench
