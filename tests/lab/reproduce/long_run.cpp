#include "tests/lab/reproduce/long_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "runtime/body.h"
#include "runtime/energy_bound.h"
#include "tests/lab/work/failure.h"
#include "tests/lab/work/store.h"

namespace tremolo::reproduce {

template <class Archive>
void fields(Archive& archive, Windows& windows) {
  archive("length", windows.length, "count", windows.count, "taken", windows.taken, "sum",
          windows.sum, "means", windows.means, "first", windows.first, "last", windows.last);
}

template <class Archive>
void fields(Archive& archive, LongRun& run) {
  archive("done", run.done, "q", run.q, "p", run.p, "reference", run.reference, "drift", run.drift,
          "iterations", run.iterations, "total", run.total, "high_band", run.high_band, "exit_code",
          run.exit_code, "reason", run.reason);
}

namespace {

using Json = nlohmann::json;

constexpr std::chrono::seconds kCheckpointInterval{20};

std::optional<LongRun> read_checkpoint(const std::string& path, const Json& key) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return std::nullopt;
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("key", Json()) != key || !json.contains("run"))
    return std::nullopt;
  if (json.value("checksum", Json()) != checksum(json.at("run").dump())) return std::nullopt;
  try {
    return long_run_from_json(json.at("run"));
  } catch (const Failure&) {
    return std::nullopt;
  }
}

void write_checkpoint(const std::string& path, const Json& key, const LongRun& run) {
  const Json state = to_json(run);
  or_fail(write_file(
      path, Json{{"key", key}, {"run", state}, {"checksum", checksum(state.dump())}}.dump()));
}

Body make_body(const LongRunSpec& spec) {
  IntegratorOptions options;
  options.step = spec.step;
  options.tolerance = spec.tolerance;
  options.split = {.rule = SplitRule::kCount, .count = spec.low};
  return or_fail(Body::create(spec.model, spec.integrator, options));
}

bool made_step(Body& body, LongRun& run) {
  const StepReport report = body.step();
  run.iterations += report.iterations;
  if (!report.converged) {
    run.solver_gave_up(report);
    return false;
  }
  ++run.done;
  return true;
}

void sample(const Body& body, LongRun& run) {
  const Energy energy = body.energy();
  if (!(energy.total() <= kEnergyBound * run.reference)) {  // also for what is not a number
    run.bound_left();
    return;
  }
  run.drift = std::max(run.drift, std::abs(energy.total() - run.reference) / run.reference);
  run.total.take(energy.total());
  run.high_band.take(energy.high_band);
}

}  // namespace

void Windows::take(double value) {
  if (taken < length) first.push_back(value);
  if (taken >= count - length) last.push_back(value);
  sum += value;
  if (++taken % length != 0) return;
  means.push_back(sum / static_cast<double>(length));
  sum = 0.0;
}

LongRun start_long_run(const LongRunSpec& spec) {
  Body body = make_body(spec);
  or_fail(body.add_default_load({.kind = SignalKind::kImpulse}));
  LongRun run;
  run.total.length = run.high_band.length = spec.window;
  run.total.count = run.high_band.count = spec.steps / spec.sample_every;
  while (run.finished() && body.load_to_come()) made_step(body, run);
  if (run.finished()) made_step(body, run);
  run.reference = body.energy().total();
  run.q = body.state().q;
  run.p = body.state().p;
  return run;
}

bool is_over(const LongRunSpec& spec, const LongRun& run) {
  return !run.finished() || run.done >= spec.steps;
}

void advance(const LongRunSpec& spec, LongRun& run) {
  Body body = make_body(spec);
  or_fail(body.set_state(run.q, run.p));
  const std::int64_t end = std::min(spec.steps, (run.done / spec.segment + 1) * spec.segment);
  while (run.finished() && run.done < end)
    if (made_step(body, run) && run.done % spec.sample_every == 0) sample(body, run);
  run.q = body.state().q;
  run.p = body.state().p;
}

Json to_json(const LongRun& run) {
  return fields_to_json(run);
}

LongRun long_run_from_json(const Json& json) {
  try {
    return fields_from_json<LongRun>(json);
  } catch (const Json::exception& error) {
    throw Failure(content_error(std::string("not a stored long run: ") + error.what()));
  }
}

LongRun run_to_end(const LongRunSpec& spec, const std::string& checkpoint, const Json& key,
                   const std::function<void(const LongRun&)>& report) {
  std::optional<LongRun> run = read_checkpoint(checkpoint, key);
  if (!run) run = start_long_run(spec);
  auto written = std::chrono::steady_clock::now();
  while (!is_over(spec, *run)) {
    advance(spec, *run);
    const auto now = std::chrono::steady_clock::now();
    if (now - written < kCheckpointInterval || is_over(spec, *run)) continue;
    write_checkpoint(checkpoint, key, *run);
    report(*run);
    written = std::chrono::steady_clock::now();
  }
  return std::move(*run);
}

}  // namespace tremolo::reproduce
