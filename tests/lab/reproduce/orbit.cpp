#include "tests/lab/reproduce/orbit.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/energy_drift.h"
#include "runtime/body.h"
#include "tests/lab/report/chart.h"
#include "tests/lab/report/store.h"

namespace tremolo::reproduce {
namespace {

constexpr std::size_t kBuckets = 240;  // of a drawn series: a panel is 480 px wide

Result<Body> make_body(const OrbitSpec& spec) {
  IntegratorOptions options;
  options.step = spec.step;
  options.alpha = spec.alpha;
  options.tolerance = spec.tolerance;
  Result<Body> body = Body::create(spec.model, spec.integrator, options);
  if (!body) return body;
  if (Status status = body->add_default_load(Signal{.kind = spec.load}, spec.scale); !status)
    return status.error();
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

Result<Orbit> watch_orbit(const OrbitSpec& spec) {
  Result<Body> created = make_body(spec);
  if (!created) return created.error();
  Body& body = *created;
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
    drift.observe(energy.total(), body.work(), body.dissipated(), body.load_to_come());
    orbit.total.t.push_back(body.time());
    orbit.total.y.push_back(energy.total());
    orbit.highest_energy = std::max(orbit.highest_energy, energy.total());
    if (lasts || !body.load_to_come()) means.take(energy);
    if (body.steps() == steps) break;
    const StepReport step = body.step();
    if (!step.converged) {
      orbit.solver_gave_up(step);
      break;
    }
  }
  orbit.steps = body.steps();
  orbit.reached = body.time();
  orbit.iterations_per_step = static_cast<double>(body.iterations()) /
                              static_cast<double>(std::max<std::int64_t>(body.steps(), 1));
  orbit.cut_steps = body.halved_steps();
  orbit.energy_drift = drift.worst();
  store_means(means, orbit);
  thin(orbit.total.t, orbit.total.y, kBuckets);
  return orbit;
}

Result<double> time_orbit(const OrbitSpec& spec, std::int64_t steps) {
  Result<Body> body = make_body(spec);
  if (!body) return body.error();
  const auto before = std::chrono::steady_clock::now();
  for (std::int64_t i = 0; i < steps; ++i)
    if (!body->step().converged) break;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

nlohmann::json to_json(const Orbit& orbit) {
  return {{"steps", orbit.steps},
          {"reached", orbit.reached},
          {"iterations_per_step", orbit.iterations_per_step},
          {"cut_steps", orbit.cut_steps},
          {"energy_drift", orbit.energy_drift},
          {"highest_energy", orbit.highest_energy},
          {"mean_energy", orbit.mean_energy},
          {"mean_high_band", orbit.mean_high_band},
          {"exit_code", orbit.exit_code},
          {"reason", orbit.reason},
          {"t", orbit.total.t},
          {"total", orbit.total.y}};
}

Orbit orbit_from_json(const nlohmann::json& json) {
  Orbit orbit;
  orbit.steps = json.at("steps");
  orbit.reached = to_number(json.at("reached"));
  orbit.iterations_per_step = to_number(json.at("iterations_per_step"));
  orbit.cut_steps = json.at("cut_steps");
  orbit.energy_drift = to_number(json.at("energy_drift"));
  orbit.highest_energy = to_number(json.at("highest_energy"));
  orbit.mean_energy = to_number(json.at("mean_energy"));
  orbit.mean_high_band = to_number(json.at("mean_high_band"));
  orbit.exit_code = json.at("exit_code");
  orbit.reason = json.at("reason");
  orbit.total.t = json.at("t").get<std::vector<double>>();
  orbit.total.y = json.at("total").get<std::vector<double>>();
  return orbit;
}

}  // namespace tremolo::reproduce
