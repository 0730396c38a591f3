// Static equilibrium f(u) = load of the full mesh or of the reduced model.
#pragma once

#include "precompute/reference/full/step_equation.h"

namespace tremolo {

// u: displacement under the whole load. energy: V(u), J. work: load . u, J.
struct StaticSolution {
  Vector u;
  double energy = 0;
  double work = 0;
  double residual = 0;  // relative, in the energy norm of the linear solution
  int load_steps = 0;
  int iterations = 0;
  int linear_iterations = 0;
  int factorisations = 0;
};

// Returns a minimum of V(u) - load . u, reached from rest in as few load steps as converge. For a
// free body, whose system solves on the complement of the rigid motions, R^T M u = 0 and the load's
// rigid component has no effect. Throws Failure (kSolver) if load steps of 1/4096 do not converge.
StaticSolution static_solution(const SecondOrderSystem& system, const Vector& load);

}  // namespace tremolo
