#include "tests/lab/bench/precision.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/work/progress.h"

namespace tremolo::bench {
namespace {

std::vector<Scene> make_scenes(const Options& options, const std::vector<Subject>& subjects) {
  std::vector<Scene> scenes;
  for (const std::string& load : options.loads)
    for (const Subject& subject : subjects)
      for (const double amplitude : options.amplitudes)
        scenes.push_back({&subject, load, amplitude, options.duration, 0.0, ""});
  return scenes;
}

void make_references(Precision& precision, unsigned threads, const Store& store) {
  const std::vector<ReferenceMethod> methods = reference_methods();
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.scenes[i].usable()) usable.push_back(i);
  // First all orbits, so that both of a scene can be made at once; then they are read in pairs.
  for_all("references", 2 * usable.size(), threads, [&](std::size_t k) {
    reference_orbit(precision.scenes[usable[k / 2]], methods[k % 2], store);
  });
  for (const std::size_t i : usable)
    precision.references[i] =
        compare_references(reference_orbit(precision.scenes[i], methods[0], store),
                           reference_orbit(precision.scenes[i], methods[1], store), kSample);
}

void make_entries(Precision& precision, unsigned threads, const Store& store) {
  std::vector<std::size_t> measured;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.measured(i)) measured.push_back(i);
  const std::size_t methods = precision.integrators.size(), steps = precision.steps.size();
  precision.entries.resize(measured.size() * methods * steps);
  for_all("errors", measured.size() * methods, threads, [&](std::size_t k) {
    const std::size_t scene = measured[k / methods];
    const std::vector<Entry> entries =
        measure_errors(precision.scenes[scene], precision.references[scene],
                       precision.integrators[k % methods], precision.steps, store);
    for (std::size_t s = 0; s < steps; ++s) {
      precision.entries[k * steps + s] = entries[s];
      precision.entries[k * steps + s].scene = scene;
    }
  });
}

// Times of the first load's scenes serve all loads: the same model, amplitude and step.
void make_times(Precision& precision, const std::string& load, const Store& store) {
  std::vector<std::size_t> timed;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.scenes[i].load == load && precision.scenes[i].usable()) timed.push_back(i);
  const std::size_t steps = precision.steps.size();
  for_all("times", timed.size() * steps, 1, [&](std::size_t k) {
    const Scene& scene = precision.scenes[timed[k / steps]];
    const double step = precision.steps[k % steps];
    const std::vector<double> times = measure_times(scene, precision.integrators, step, store);
    for (Entry& entry : precision.entries) {
      const Scene& other = precision.scenes[entry.scene];
      if (other.subject != scene.subject || other.amplitude != scene.amplitude ||
          entry.step != step)
        continue;
      const auto at = std::ranges::find(precision.integrators, entry.integrator);
      entry.microseconds = times[at - precision.integrators.begin()];
    }
  });
}

}  // namespace

std::span<const Entry> Precision::curve(std::size_t scene, const std::string& integrator) const {
  const auto begin = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
    return entry.scene == scene && entry.integrator == integrator;
  });
  if (begin == entries.end()) return {};
  return {begin, begin + static_cast<std::ptrdiff_t>(steps.size())};
}

Precision measure_precision(const Options& options, std::vector<SampleModel> models,
                            const Store& store) {
  const unsigned threads = thread_count(options.threads);
  Precision precision;
  precision.integrators = options.integrators;
  for (const double ms : options.steps_ms) precision.steps.push_back(1e-3 * ms);
  for (SampleModel& model : models) precision.subjects.push_back(make_subject(std::move(model)));
  precision.scenes = make_scenes(options, precision.subjects);
  precision.references.resize(precision.scenes.size());
  for_all("loads", precision.scenes.size(), threads,
          [&](std::size_t i) { find_scale(precision.scenes[i], store); });
  make_references(precision, threads, store);
  make_entries(precision, threads, store);
  const bool square = std::ranges::find(options.loads, "square") != options.loads.end();
  make_times(precision, square ? "square" : options.loads.front(), store);
  return precision;
}

std::optional<Cost> cost_of_error(std::span<const Entry> curve, double target, double gap) {
  const auto error = [&](const Entry& entry) { return std::max(entry.error, kAbove * gap); };
  std::optional<Cost> best;
  const auto offer = [&](Cost cost) {
    if (std::isfinite(cost.value) && (!best || cost.value < best->value)) best = cost;
  };
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (!(error(curve[i]) <= target)) continue;
    if (i == 0) {
      offer({curve[i].cost(), true});
      continue;
    }
    const double before = error(curve[i - 1]), after = error(curve[i]);
    if (before <= target) continue;
    // If the longer step failed, or was not timed, there is nothing to interpolate with.
    if (!std::isfinite(before) || !std::isfinite(curve[i - 1].cost())) {
      offer({curve[i].cost(), false});
      continue;
    }
    const double part = std::log(before / target) / std::log(before / after);
    const double rise = std::log(curve[i].cost() / curve[i - 1].cost());
    offer({curve[i - 1].cost() * std::exp(part * rise), false});
  }
  return best;
}

std::vector<double> cost_ratios(const Precision& precision, const std::string& method,
                                const std::string& other, double target) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (!precision.measured(i)) continue;
    const double gap = precision.references[i].gap;
    const std::optional<Cost> mine = cost_of_error(precision.curve(i, method), target, gap);
    const std::optional<Cost> theirs = cost_of_error(precision.curve(i, other), target, gap);
    if (mine && theirs)
      ratios.push_back(theirs->value / mine->value);
    else if (mine)
      ratios.push_back(std::numeric_limits<double>::infinity());
    else if (theirs)
      ratios.push_back(0.0);
  }
  return ratios;
}

std::vector<Standing> standings(const Precision& precision, double target) {
  std::vector<Standing> table;
  std::vector<std::vector<double>> slowdowns(precision.integrators.size());
  for (const std::string& integrator : precision.integrators)
    table.push_back({integrator, 0, 0, 0, 0.0});
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (!precision.measured(i)) continue;
    std::vector<double> costs;
    for (const std::string& integrator : precision.integrators) {
      const auto cost =
          cost_of_error(precision.curve(i, integrator), target, precision.references[i].gap);
      costs.push_back(cost ? cost->value : std::numeric_limits<double>::infinity());
    }
    const double best = *std::min_element(costs.begin(), costs.end());
    for (std::size_t m = 0; m < costs.size(); ++m) {
      ++table[m].scenes;
      if (!std::isfinite(costs[m])) continue;
      ++table[m].reached;
      if (costs[m] == best) ++table[m].wins;
      slowdowns[m].push_back(costs[m] / best);
    }
  }
  for (std::size_t m = 0; m < table.size(); ++m) table[m].slowdown = median(slowdowns[m]);
  std::stable_sort(table.begin(), table.end(), [](const Standing& a, const Standing& b) {
    if (a.reached != b.reached) return a.reached > b.reached;
    return a.slowdown < b.slowdown;
  });
  return table;
}

}  // namespace tremolo::bench
