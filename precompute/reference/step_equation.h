// One nonlinear equation for all that the reference solves: a step of the implicit midpoint rule, a
// step of the energy-preserving rule, statics. Of the full mesh and of the reduced model alike.
//
// For the change d of the displacements from `origin`:
//   g(d) = mass M d + rest K d + sum_i w_i f(origin + s_i d) + constant = 0,   f = grad V.
// g is the gradient of 1/2 mass d^T M d + 1/2 rest d^T K d + sum_i (w_i / s_i) V(origin + s_i d)
// + constant . d, a quartic along every line, and its derivative is symmetric.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

using Vector = Eigen::VectorXd;

// Where on the segment from origin to origin + d the force is taken, and how it counts.
struct SegmentPoint {
  double weight = 1;    // w
  double fraction = 1;  // s
};

// mass: 1/s^2; rest: dimensionless. constant: N.
struct StepEquation {
  double mass = 0;
  double rest = 0;
  std::vector<SegmentPoint> points;
  Vector origin;
  Vector constant;
};

// How a solve ended. residual, scale: |g| at the end and what it is compared with, both in the norm
// of the inverse of the equation's derivative, J^(1/2): what is left does not do more work than
// residual * |d| in the derivative's norm.
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

// A system  M u'' + f(u) = load  as what moves it needs to know. solve: d holds the guess, then the
// solution; energy (J): its root is what the residual is compared with, 0: the first residual.
struct SecondOrderSystem {
  Eigen::Index size = 0;
  std::function<Vector(const Vector&)> mass_times;
  std::function<Vector(const Vector&)> rest_times;
  std::function<double(const Vector&)> energy;  // V, J
  std::function<SolveReport(const StepEquation&, double energy, Vector& d)> solve;
};

// Slope along a line: a cubic, from its values at 0, 1/2 and 1 and its derivative at 0. Returns the
// first t > 0 at which a negative slope becomes positive, at most `most`.
double first_minimum(double slope, double curvature, double slope_half, double slope_one,
                     double most);

// A step that leads downhill, and step . J step.
struct Direction {
  Vector step;
  double curvature = 0;
};

// d += t step, g = gradient(d): t = 1 where that takes at least half of the slope along the step
// away, else the exact minimum along it.
void move_along(const std::function<Vector(const Vector&)>& gradient, const Direction& direction,
                Vector& d, Vector& g);

}  // namespace tremolo
