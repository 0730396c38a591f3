// One run of one model from rest: the time it reached, its energy over time, and, measured
// separately, how long its steps take.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/load.h"
#include "runtime/model.h"

namespace tremolo::reproduce {

// Tolerance of every solve, relative (imexv-thesis: absolute, in units of q).
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

// H is evaluated after every step. Throws a Failure as Body::create and add_default_load. A run
// that broke off is a result.
Orbit run_orbit(const OrbitSpec& spec);

// Seconds of `steps` calls of step() and of nothing else. Stops early where the solver gives up.
double time_orbit(const OrbitSpec& spec, std::int64_t steps);

// The stored data of an orbit.
template <class Archive>
void fields(Archive& archive, Orbit& orbit) {
  archive("steps", orbit.steps, "reached", orbit.reached, "iterations_per_step",
          orbit.iterations_per_step, "cut_steps", orbit.cut_steps, "energy_drift",
          orbit.energy_drift, "highest_energy", orbit.highest_energy, "mean_energy",
          orbit.mean_energy, "mean_high_band", orbit.mean_high_band, "exit_code", orbit.exit_code,
          "reason", orbit.reason, "t", orbit.total.t, "total", orbit.total.y);
}

}  // namespace tremolo::reproduce
