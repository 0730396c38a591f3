#include "tests/lab/reproduce/long_run.h"

#include <algorithm>
#include <cmath>

#include "runtime/body.h"
#include "runtime/energy_bound.h"
#include "tests/lab/work/failure.h"

namespace tremolo::reproduce {
namespace {

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

}  // namespace tremolo::reproduce
