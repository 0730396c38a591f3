#include "tests/lab/reproduce/orbit.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/energy.h"
#include "runtime/apps/tremolo/output/chart.h"
#include "runtime/body.h"
#include "tests/lab/work/failure.h"

namespace tremolo::reproduce {
namespace {

constexpr std::size_t kBuckets = 240;  // of a drawn series: a panel is 480 px wide

Body make_body(const OrbitSpec& spec) {
  IntegratorOptions options;
  options.step = spec.step;
  options.alpha = spec.alpha;
  options.tolerance = spec.tolerance;
  Body body = or_fail(Body::create(spec.model, spec.integrator, options));
  or_fail(body.add_default_load(Signal{.kind = spec.load}, spec.scale));
  return body;
}

std::int64_t step_count(const OrbitSpec& spec) {
  return std::llround(spec.duration / spec.step);
}

// Means over the part of a run that counts.
struct Means {
  double energy = 0.0, high_band = 0.0;
  std::int64_t count = 0;

  void take(const Energy& now) {
    energy += now.total();
    high_band += now.high_band;
    ++count;
  }
};

void store_means(const Means& means, Orbit& orbit) {
  const double count = static_cast<double>(std::max<std::int64_t>(means.count, 1));
  orbit.mean_energy = means.energy / count;
  orbit.mean_high_band = means.high_band / count;
}

}  // namespace

Orbit run_orbit(const OrbitSpec& spec) {
  Body body = make_body(spec);
  const std::int64_t steps = step_count(spec);
  const bool lasts = !std::isfinite(signal_end(Signal{.kind = spec.load}));
  Orbit orbit;
  DriftMeter drift;
  Means means;
  orbit.total.t.reserve(static_cast<std::size_t>(steps) + 1);
  orbit.total.y.reserve(static_cast<std::size_t>(steps) + 1);
  for (;;) {
    const Energy energy = body.energy();
    if (!body.energy_bound().sound(energy.total())) {
      orbit.bound_left();
      break;
    }
    drift.observe(energy.total(), body.sums().work, body.sums().dissipated, body.load_to_come());
    orbit.total.t.push_back(body.time());
    orbit.total.y.push_back(energy.total());
    orbit.highest_energy = std::max(orbit.highest_energy, energy.total());
    if (lasts || !body.load_to_come()) means.take(energy);
    if (body.counts().steps == steps) break;
    const StepReport step = body.step();
    if (!step.converged) {
      orbit.solver_gave_up(step);
      break;
    }
  }
  orbit.steps = body.counts().steps;
  orbit.reached = body.time();
  orbit.iterations_per_step = static_cast<double>(body.counts().iterations) /
                              static_cast<double>(std::max<std::int64_t>(body.counts().steps, 1));
  orbit.cut_steps = body.counts().halved;
  orbit.energy_drift = drift.worst();
  store_means(means, orbit);
  thin(orbit.total.t, orbit.total.y, kBuckets);
  return orbit;
}

double time_orbit(const OrbitSpec& spec, std::int64_t steps) {
  Body body = make_body(spec);
  const auto before = std::chrono::steady_clock::now();
  for (std::int64_t i = 0; i < steps; ++i)
    if (!body.step().converged) break;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

}  // namespace tremolo::reproduce
