#include "tests/lab/bench/measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "common/hash.h"
#include "common/processor.h"
#include "formats/file/input_file.h"
#include "runtime/body.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {

// The stored data of an entry.
template <class Archive>
void fields(Archive& archive, Entry& entry) {
  archive("step", entry.step, "error", entry.error, "below", entry.below_reference, "drift",
          entry.drift, "band", entry.band_ratio, "iterations", entry.iterations, "reached",
          entry.reached, "exit_code", entry.exit_code, "reason", entry.reason);
}

namespace {

using Json = nlohmann::json;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kLeastWindows = 5;  // windows of each method at least
constexpr int kMaxRepeats = 25;   // at most, while
constexpr double kClose = 1.05;   // a method's two fastest windows differ by more than this

Entry make_entry(const Scene& scene, const Reference& reference, const SampledRun& run,
                 const std::string& integrator, double step) {
  Entry entry;
  entry.integrator = integrator;
  entry.step = step;
  entry.error = trajectory_error(run.q, reference.q, reference.horizon);
  if (!std::isfinite(entry.error)) entry.error = std::numeric_limits<double>::infinity();
  entry.below_reference = entry.error < kAbove * reference.gap;
  entry.drift = run.drift;
  entry.band_ratio = run.high_band / reference.high_band;
  if (scene.subject->band == scene.subject->sample.model->modes()) entry.band_ratio = kNan;
  entry.iterations = run.iterations_per_step;
  entry.reached = run.reached;
  entry.exit_code = run.exit_code;
  entry.reason = run.reason;
  return entry;
}

// A body whose load has ended; each timed window starts from that state.
struct Runner {
  Body body;
  State start;
  double best = std::numeric_limits<double>::infinity();    // s a window
  double second = std::numeric_limits<double>::infinity();  // the next to the best
  bool good = true;

  bool settled() const { return !good || second <= kClose * best; }
};

// The body of a scene with its load, at rest.
Body make_body(const RunSpec& spec) {
  Body body = or_fail(Body::create(spec.model, spec.integrator, spec.options));
  or_fail(body.add_load(spec.load));
  return body;
}

Runner make_runner(const Scene& scene, const std::string& integrator, double step) {
  const RunSpec spec = scene.run(integrator, step);
  Runner runner{make_body(spec), {}};
  const double end = signal_end(spec.load.signal);
  const auto steps =
      static_cast<std::int64_t>(std::ceil((std::isfinite(end) ? end : 0.3) / step - 1e-9)) + 1;
  while (runner.good && runner.body.counts().steps < steps)
    runner.good = runner.body.step().converged;
  runner.start = runner.body.state();
  return runner;
}

void time_window(Runner& runner, int steps) {
  if (!runner.good || !runner.body.set_state(runner.start.q, runner.start.p)) return;
  const double before = processor_time();
  for (int k = 0; k < steps && runner.good; ++k) runner.good = runner.body.step().converged;
  const double spent = processor_time() - before;
  runner.second = std::min(runner.second, std::max(runner.best, spent));
  runner.best = std::min(runner.best, spent);
}

Json take_turns(const Scene& scene, const std::vector<std::string>& integrators, double step) {
  std::vector<Runner> runners;
  for (const std::string& integrator : integrators)
    runners.push_back(make_runner(scene, integrator, step));
  const int steps = static_cast<int>(std::clamp(0.6 / step, 100.0, 1000.0));
  for (int repeat = 0; repeat < kMaxRepeats; ++repeat) {
    if (repeat >= kLeastWindows && std::ranges::all_of(runners, &Runner::settled)) break;
    for (Runner& runner : runners)
      if (repeat < kLeastWindows || !runner.settled()) time_window(runner, steps);
  }
  Json times = Json::array();
  for (const Runner& runner : runners)
    times.push_back(runner.good ? Json(1e6 * runner.best / steps) : Json(nullptr));
  return times;
}

}  // namespace

std::string build_id() {
  static const std::string id = [] {
    const Result<std::string> program = program_checksum();
    return program ? *program : std::string("?");
  }();
  return id;
}

std::string fingerprint(const Scene& scene, const std::string& integrator, double step) {
  Body body = make_body(scene.run(integrator, step));
  for (int k = 0; k < 100 && body.step().converged; ++k) {
  }
  Eigen::MatrixXd state(body.state().q.size(), 2);
  state << body.state().q, body.state().p;
  return hash_text(
      hash_bytes(std::as_bytes(std::span(state.data(), static_cast<std::size_t>(state.size())))));
}

std::vector<Entry> measure_errors(const Scene& scene, const Reference& reference,
                                  const std::string& integrator, const std::vector<double>& steps,
                                  const Store& store) {
  Json key = scene.key();
  key["integrator"] = integrator;
  key["steps"] = steps;
  key["horizon"] = reference.horizon;
  key["gap"] = reference.gap;
  for (const double step : {steps.front(), steps.back()})
    key["fingerprint"].push_back(fingerprint(scene, integrator, step));
  const Json stored = store.get("error-" + scene.name() + "-" + integrator, key, [&] {
    Json entries = Json::array();
    for (const double step : steps) {
      RunSpec spec = scene.run(integrator, step);
      spec.keep_orbit = true;
      entries.push_back(
          fields_to_json(make_entry(scene, reference, run_sampled(spec), integrator, step)));
    }
    return entries;
  });
  std::vector<Entry> entries;
  for (const Json& one : stored) {
    Entry entry = fields_from_json<Entry>(one);
    entry.integrator = integrator;
    entry.microseconds = kNan;
    if (std::isnan(entry.error)) entry.error = std::numeric_limits<double>::infinity();
    entries.push_back(std::move(entry));
  }
  return entries;
}

std::vector<double> measure_times(const Scene& scene, const std::vector<std::string>& integrators,
                                  double step, const Store& store) {
  Json key = scene.key();
  key["integrators"] = integrators;
  key["step"] = step;
  key["build"] = build_id();
  const Json stored = store.get(fmt::format("time-{}-{:g}", scene.name(), 1e3 * step), key,
                                [&] { return take_turns(scene, integrators, step); });
  std::vector<double> times;
  for (const Json& time : stored) times.push_back(to_number(time));
  return times;
}

}  // namespace tremolo::bench
