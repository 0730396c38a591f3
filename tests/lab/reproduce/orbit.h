// One run of one model from rest: how far it came, its energy over time, and, apart from that, how
// long its steps take.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/program/output/ending.h"

namespace tremolo::reproduce {

// Of every solve, relative (imexv-thesis: absolute, in units of q).
inline constexpr double kTolerance = 1e-6;

// scale: times the model's default load. alpha: 1/s. step, duration: s.
struct OrbitSpec {
  Model::Pointer model;
  std::string integrator;
  SignalKind load = SignalKind::kImpulse;
  double alpha = 0.0;
  double scale = 1.0;
  double step = 3e-3;
  double duration = 30.0;
  double tolerance = kTolerance;
};

// y over t (s), thinned for a picture.
struct Series {
  std::vector<double> t;
  std::vector<double> y;
};

// reached: s. cut_steps: steps that were taken in parts. energy_drift: as energy_drift_max in
// docs/reference.md. mean_energy, mean_high_band: of all steps after the load has ended, of all
// if it lasts, J. total: H, J.
struct Orbit : Ending {
  std::int64_t steps = 0;
  double reached = 0.0;
  double iterations_per_step = 0.0;
  std::int64_t cut_steps = 0;
  double energy_drift = 0.0;
  double highest_energy = 0.0;
  double mean_energy = 0.0;
  double mean_high_band = 0.0;
  Series total;
};

// H is evaluated after every step. Errors: what Body::create and add_default_load give. A run that
// broke off is a result.
Result<Orbit> watch_orbit(const OrbitSpec& spec);

// Seconds of `steps` calls of step() and of nothing else. Stops early where the solver gives up.
Result<double> time_orbit(const OrbitSpec& spec, std::int64_t steps);

nlohmann::json to_json(const Orbit& orbit);
Orbit orbit_from_json(const nlohmann::json& json);

}  // namespace tremolo::reproduce
