// Reference orbits of damped motion by a method that has nothing in common with the integrators
// that it judges: Radau IIA of order 5 (Hairer & Wanner 1996, table IV.5.6), stiffly accurate,
// right on slaved coordinates at any D h.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/load.h"
#include "runtime/model.h"

namespace tremolo::damping {

// alpha, beta: Rayleigh's, 1/s and s. step: s; `sample` is a multiple of it, and the load may jump
// at multiples of it only.
// strain_gram: as BasisData has it; empty: the damping of the rest shape.
struct StiffProblem {
  Model::Pointer model;
  std::vector<double> strain_gram = {};
  double alpha = 0.0;
  double beta = 0.0;
  Load load;
  double duration = 2.0;
  double sample = 6e-3;
  double step = 5e-4;
};

// q from rest, r x samples, column k at (k + 1) sample. Throws a Failure (kSolver) for a step whose
// equations could not be solved to 1e-12.
Eigen::MatrixXd stiff_orbit(const StiffProblem& problem);

}  // namespace tremolo::damping
