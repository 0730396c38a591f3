// Energy of a state, by kind and by band, and how far an orbit drifts from its balance.
#pragma once

#include <Eigen/Core>

#include "runtime/integrator.h"
#include "runtime/kernels/potential.h"

namespace tremolo {

// All in J. high_band: sum over the coordinates i >= low of 1/2 p_i^2 + 1/2 R_i(q)^2 / lambda_i,
// the energy with which the high rows oscillate about the place to which the low ones push them.
// For a linear force it is the harmonic energy 1/2 p_i^2 + 1/2 lambda_i q_i^2. That one itself says
// little in large motion: modal derivatives follow the low modes statically, q_h is large, and
// the coupling terms of V cancel most of 1/2 lambda_h q_h^2.
struct Energy {
  double kinetic = 0.0;
  double potential = 0.0;
  double high_band = 0.0;
  double total() const { return kinetic + potential; }
};

double kinetic_energy(const Eigen::VectorXd& p);

// The sum over i in [low, r), as above. force: R(q), r.
double band_energy(const Eigen::VectorXd& lambda, const Eigen::VectorXd& force,
                   const Eigen::VectorXd& p, Eigen::Index low);

// Watches H over a run and says how far it left what it should be (docs/architecture.md,
// `energy_drift_max`). observe() takes, once before the first step and once after each: H, the work
// of the loads and the dissipated energy, both since the start, and whether a load still acts on a
// coming step.
class DriftMeter {
 public:
  void observe(double energy, double work, double dissipated, bool load_to_come);

  // After the loads have ended: max |H - H_ref + dissipated since| / H_ref, H_ref = H at that
  // moment (without damping: |H - H_ref| / H_ref). While a load lasts:
  // max |H - H_start - work + dissipated| / max H. Zero while there is no energy at all.
  double worst() const;

 private:
  bool started_ = false;
  bool free_ = false;
  double start_energy_ = 0.0;
  double highest_ = 0.0;
  double loaded_error_ = 0.0;
  double reference_ = 0.0;  // H + dissipated when the loads ended
  double reference_energy_ = 0.0;
  double free_error_ = 0.0;
};

}  // namespace tremolo
