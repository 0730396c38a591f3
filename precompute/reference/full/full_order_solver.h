// Newton's method for a StepEquation of the full mesh. Linear systems are solved by conjugate
// gradients, preconditioned with a Cholesky factor of an earlier tangent that is renewed when it
// becomes inefficient. Where the tangent is indefinite the direction is still a descent direction.
// A step that overshoots is replaced by the exact minimum along the line.
#pragma once

#include <deque>
#include <memory>

#include "precompute/reference/full/full_order.h"
#include "precompute/reference/full/step_equation.h"
#include "precompute/solver/sparse_cholesky.h"

namespace tremolo {

// Limited-memory BFGS updates (Nocedal 1980, two-loop recursion) that correct an approximate
// inverse P^-1 of an equation's derivative. With a good P they replace new tangents.

struct SecantUpdates {
  struct Pair {
    Vector step, change;  // s, and y: the gradient's change over s
    double product = 0;   // s . y > 0
  };
  std::deque<Pair> pairs;  // oldest first
};

// Adds a pair; pairs with s . y <= 0 are discarded.
void add_pair(Vector step, Vector change, SecantUpdates& updates);

// Returns the corrected inverse times g. inverse: x -> P^-1 x, symmetric and positive definite.
Vector apply_inverse(const SecantUpdates& updates,
                     const std::function<Vector(const Vector&)>& inverse, const Vector& g);

// The body (not owned) and the state kept between solves.
struct FullOrderSolver {
  const FullOrder* body = nullptr;
  SolveOptions options;
  std::vector<double> tangent;  // of the last evaluation
  std::unique_ptr<SparseCholesky> factor;
  double mass = 0, rest = 0;  // coefficients of the equation that was factorised
  bool stale = true;          // the factor should be renewed
};

// Returns the residual g(d) without its rigid component, N.
Vector equation_gradient(const FullOrder& body, const StepEquation& equation, const Vector& d);

// Computes the derivative of g at d on the body's pattern, without the rigid projection.
void equation_tangent(const FullOrder& body, const StepEquation& equation, const Vector& d,
                      std::vector<double>& values);

// See SecondOrderSystem::solve. Throws Failure: kSolver if even the stiffness at rest cannot be
// factorised, kSystem if memory runs out.
SolveReport solve(FullOrderSolver& solver, const StepEquation& equation, double energy, Vector& d);

// Returns K^-1 force on the complement of the rigid motions. Throws Failure as solve() does, and
// kSolver if it does not converge.
Vector linear_response(FullOrderSolver& solver, const Vector& force);

// Returns the interface for time integration and statics; it holds a reference to the solver.
SecondOrderSystem make_system(FullOrderSolver& solver);

}  // namespace tremolo
