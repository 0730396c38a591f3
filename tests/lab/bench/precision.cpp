#include "tests/lab/bench/precision.h"

#include <algorithm>

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
      entry.microseconds = times[static_cast<std::size_t>(at - precision.integrators.begin())];
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

}  // namespace tremolo::bench
