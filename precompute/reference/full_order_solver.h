// Newton's method for a StepEquation of the full mesh. The linear systems are solved by conjugate
// gradients behind a Cholesky factor of an earlier tangent, which is made anew when it no longer
// helps; where the tangent is not positive definite the direction still leads downhill. Steps that
// overshoot go to the minimum along the line, found exactly.
#pragma once

#include <memory>

#include "precompute/reference/full_order.h"
#include "precompute/reference/statics.h"
#include "precompute/solver/sparse_cholesky.h"

namespace tremolo {

// The body (borrowed) with what is kept from one solve to the next.
struct FullOrderSolver {
  const FullOrder* body = nullptr;
  SolveOptions options;
  std::vector<double> tangent;  // of the last evaluation
  std::unique_ptr<SparseCholesky> factor;
  double mass = 0, rest = 0;  // coefficients of the equation that the factor was made for
  bool stale = true;          // the factor should be made anew
};

// g at d, rigid share taken out, N.
Vector equation_gradient(const FullOrder& body, const StepEquation& equation, const Vector& d);

// values <- the derivative of g at d on the body's pattern, without the rigid projection.
void equation_tangent(const FullOrder& body, const StepEquation& equation, const Vector& d,
                      std::vector<double>& values);

// As SecondOrderSystem::solve. Throws Failure (kSolver) when even the stiffness at rest cannot be
// factorised, kSystem when memory runs out.
SolveReport solve(FullOrderSolver& solver, const StepEquation& equation, double energy, Vector& d);

// K^-1 force, on the complement of the rigid motions. Throws Failure like solve(), and kSolver when
// it does not converge.
Vector linear_response(FullOrderSolver& solver, const Vector& force);

// The system as time integration and statics want it. Borrows the solver.
SecondOrderSystem make_system(FullOrderSolver& solver);

}  // namespace tremolo
