// Energy of a state, by kind and by band.
#pragma once

#include <Eigen/Core>

#include "runtime/integrator.h"
#include "runtime/math/kernels/potential.h"

namespace tremolo {

// Energies of a state, J.
struct Energy {
  // Sum over the coordinates i >= low of 1/2 p_i^2 + 1/2 R_i(q)^2 / lambda_i: the energy with which
  // the high rows oscillate about the position to which the low ones push them. For a linear force
  // it is the harmonic energy 1/2 p_i^2 + 1/2 lambda_i q_i^2. In large motion the harmonic energy
  // is not meaningful: modal derivatives follow the low modes statically, q_h is large, and the
  // coupling terms of V cancel most of 1/2 lambda_h q_h^2.
  double kinetic = 0.0;
  double potential = 0.0;
  double high_band = 0.0;
  double total() const { return kinetic + potential; }
};

double kinetic_energy(const Eigen::VectorXd& p);

// The sum over i in [low, r), same as for Energy::high_band. force: R(q), r.
double band_energy(const Eigen::VectorXd& lambda, const Eigen::VectorXd& force,
                   const Eigen::VectorXd& p, Eigen::Index low);

}  // namespace tremolo
