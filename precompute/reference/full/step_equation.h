// The nonlinear equation behind all solves of the reference: a step of the implicit midpoint rule,
// a step of the energy-preserving rule, and statics, for the full mesh and the reduced model.
//
// For the change d of the displacements from `origin`:
//   g(d) = mass M d + rest K d + sum_i w_i f(origin + s_i d) + constant = 0,   f = grad V.
// g is the gradient of 1/2 mass d^T M d + 1/2 rest d^T K d + sum_i (w_i / s_i) V(origin + s_i d) +
// constant . d, which is quartic along every line; the derivative of g is symmetric.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

using Vector = Eigen::VectorXd;

// A point on the segment from origin to origin + d at which the force is evaluated, and its weight.
// rate: the stress is not that of the strain there but that of the strain's change E(origin + d) -
// E(origin). In the middle of the segment that is stiffness damping: the force's product with d is
// the integral of the change's product with its stress, never negative. It is no gradient; of its
// derivative the symmetric part at the point is taken.
struct SegmentPoint {
  double weight = 1;    // w
  double fraction = 1;  // s
  bool rate = false;
};

// mass: 1/s^2; rest: dimensionless. constant: N.
struct StepEquation {
  double mass = 0;
  double rest = 0;
  std::vector<SegmentPoint> points;
  Vector origin;
  Vector constant;
};

// Outcome of a solve. residual, scale: final |g| and its reference value, both in the norm of the
// inverse of the equation's derivative, J^(1/2). The remaining force does at most the work residual
// * |d|, with |d| in the derivative's norm.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  int linear_iterations = 0;
  int factorisations = 0;
  double residual = 0;
  double scale = 0;
};

struct SolveOptions {
  double tolerance = 1e-9;  // residual / scale
  int max_iterations = 60;
};

// A system M u'' + f(u) = load, as an interface for statics and time integration. solve: d contains
// the initial guess and receives the solution; sqrt(energy), with energy in J, is the scale of the
// residual; 0: the first residual is.
struct SecondOrderSystem {
  Eigen::Index size = 0;
  std::function<Vector(const Vector&)> mass_times;
  // The integral of dE : C : dE over the change of the strains from u to u + d, J.
  std::function<double(const Vector& u, const Vector& d)> strain_change_work;
  std::function<double(const Vector&)> energy;  // V, J
  std::function<SolveReport(const StepEquation&, double energy, Vector& d)> solve;
};

// Returns the first t > 0 at which the slope along a line changes from negative to positive, at
// most `most`. The slope is the cubic with the given values at 0, 1/2 and 1 and derivative
// `curvature` at 0.
double first_minimum(double slope, double curvature, double slope_half, double slope_one,
                     double most);

// A descent step, and its curvature step . J step.
struct Direction {
  Vector step;
  double curvature = 0;
};

// Sets d += t step and g = gradient(d), with t = 1 if that at least halves the slope along the
// step, else at the exact minimum along it.
void move_along(const std::function<Vector(const Vector&)>& gradient, const Direction& direction,
                Vector& d, Vector& g);

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
