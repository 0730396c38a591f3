// Static equilibrium f(u) = load, of the full mesh or of the reduced model.
#pragma once

#include "precompute/reference/step_equation.h"

namespace tremolo {

// u: the displacement where the whole load acts. energy: V(u), J. work: load . u, J.
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

// A minimum of V(u) - load . u, reached from rest by as few load steps as converge. Of a free body
// (its system solves on the complement of the rigid motions) R^T M u = 0, and the rigid share of
// the load does nothing. Throws Failure (kSolver) when load steps of 1/4096 do not converge.
StaticSolution static_solution(const SecondOrderSystem& system, const Vector& load);

}  // namespace tremolo
