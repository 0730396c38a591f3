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

}  // namespace tremolo
