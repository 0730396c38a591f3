#include "tests/lab/bench/precision.h"

#include <algorithm>

#include "runtime/program/output/progress.h"

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

Status make_references(Precision& precision, unsigned threads, const Store& store) {
  const std::vector<ReferenceMethod> methods = reference_methods();
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.scenes[i].usable()) usable.push_back(i);
  // First all orbits, so that both of a scene can be made at once; then they are read in pairs.
  Status status = for_all("references", 2 * usable.size(), threads, [&](std::size_t k) -> Status {
    Result<SampledRun> run =
        reference_orbit(precision.scenes[usable[k / 2]], methods[k % 2], store);
    if (!run) return run.error();
    return Success{};
  });
  if (!status) return status;
  for (const std::size_t i : usable) {
    Result<SampledRun> one = reference_orbit(precision.scenes[i], methods[0], store);
    if (!one) return one.error();
    Result<SampledRun> other = reference_orbit(precision.scenes[i], methods[1], store);
    if (!other) return other.error();
    precision.references[i] = compare_references(*one, *other, kSample);
  }
  return Success{};
}

Status make_entries(Precision& precision, unsigned threads, const Store& store) {
  std::vector<std::size_t> measured;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.measured(i)) measured.push_back(i);
  const std::size_t methods = precision.integrators.size(), steps = precision.steps.size();
  precision.entries.resize(measured.size() * methods * steps);
  return for_all("errors", measured.size() * methods, threads, [&](std::size_t k) -> Status {
    const std::size_t scene = measured[k / methods];
    Result<std::vector<Entry>> entries =
        measure_errors(precision.scenes[scene], precision.references[scene],
                       precision.integrators[k % methods], precision.steps, store);
    if (!entries) return entries.error();
    for (std::size_t s = 0; s < steps; ++s) {
      precision.entries[k * steps + s] = (*entries)[s];
      precision.entries[k * steps + s].scene = scene;
    }
    return Success{};
  });
}

// Times of the first load's scenes serve all loads: the same model, amplitude and step.
Status make_times(Precision& precision, const std::string& load, const Store& store) {
  std::vector<std::size_t> timed;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    if (precision.scenes[i].load == load && precision.scenes[i].usable()) timed.push_back(i);
  const std::size_t steps = precision.steps.size();
  return for_all("times", timed.size() * steps, 1, [&](std::size_t k) -> Status {
    const Scene& scene = precision.scenes[timed[k / steps]];
    const double step = precision.steps[k % steps];
    Result<std::vector<double>> times = measure_times(scene, precision.integrators, step, store);
    if (!times) return times.error();
    for (Entry& entry : precision.entries) {
      const Scene& other = precision.scenes[entry.scene];
      if (other.subject != scene.subject || other.amplitude != scene.amplitude ||
          entry.step != step)
        continue;
      const auto at =
          std::find(precision.integrators.begin(), precision.integrators.end(), entry.integrator) -
          precision.integrators.begin();
      entry.microseconds = (*times)[static_cast<std::size_t>(at)];
    }
    return Success{};
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

Result<Precision> measure_precision(const Options& options, std::vector<SampleModel> models,
                                    const Store& store) {
  const unsigned threads = thread_count(options.threads);
  Precision precision;
  precision.integrators = options.integrators;
  for (const double ms : options.steps_ms) precision.steps.push_back(1e-3 * ms);
  for (SampleModel& model : models) {
    Result<Subject> subject = make_subject(std::move(model));
    if (!subject) return subject.error();
    precision.subjects.push_back(std::move(*subject));
  }
  precision.scenes = make_scenes(options, precision.subjects);
  precision.references.resize(precision.scenes.size());
  Status status = for_all("loads", precision.scenes.size(), threads,
                          [&](std::size_t i) { return find_scale(precision.scenes[i], store); });
  if (!status) return status.error();
  if (status = make_references(precision, threads, store); !status) return status.error();
  if (status = make_entries(precision, threads, store); !status) return status.error();
  const bool square =
      std::find(options.loads.begin(), options.loads.end(), "square") != options.loads.end();
  status = make_times(precision, square ? "square" : options.loads.front(), store);
  if (!status) return status.error();
  return precision;
}

}  // namespace tremolo::bench
