// Newton's method for the equation of one implicit step, in storage that is made once.
//
// The residual g of every implicit method here is the gradient of a functional of the unknowns (so
// the Jacobian is symmetric), and for a quartic V that functional is a quartic along any line. A
// correction c that solves J c = g is used whole where it brings |g| down. Where it does not, the
// slope -g(x - t c).c, a cubic in t known from its values and derivatives at both ends, is solved
// for its first zero: an exact line search without another evaluation. An indefinite Jacobian is
// shifted to the nearest convenient positive definite one, so that c always leads downhill.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "runtime/integrators/integrator.h"

namespace tremolo {

// unknowns, residual, correction: n. jacobian: d residual / d unknowns, n x n, symmetric, both
// triangles filled.
struct NewtonWorkspace {
  explicit NewtonWorkspace(Eigen::Index n);

  Eigen::VectorXd unknowns;
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd correction;
  Eigen::VectorXd image;  // jacobian * correction
  Eigen::LLT<Eigen::MatrixXd> cholesky;
  double shift = 0.0;  // what was added to the Jacobian's diagonal before it was factored
};

// Factors the Jacobian, shifted if it is not positive definite. False if it is not finite.
bool factor_jacobian(NewtonWorkspace& workspace);

// correction = (jacobian + shift)^-1 residual, by the last factor.
void solve_correction(NewtonWorkspace& workspace);

// The first zero in (0, 4 end], 4 end if there is none, of the cubic s with s(0) = slope0 < 0,
// s'(0) = bend0, s(end) = slope1, s'(end) = bend1.
double first_zero(double end, double slope0, double bend0, double slope1, double bend1);

// Of the unknowns, relative: a few units in the last place.
inline constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();

// Corrects workspace.unknowns until the residual is small enough, at most max_iterations times.
// evaluate(): fills residual and jacobian for the present unknowns and returns the residual's size
// divided by what is allowed, so that <= 1 is convergence; a correction that is lost in the
// rounding of the unknowns is convergence too, since h^2 omega^2 may lift the residual's rounding
// above any tolerance. The report's residual is the Euclidean norm.
template <class Evaluate>
StepReport solve_newton(NewtonWorkspace& workspace, int max_iterations, Evaluate&& evaluate) {
  StepReport report;
  double ratio = evaluate();
  for (;; ++report.iterations) {
    report.converged = ratio <= 1.0;  // false for NaN
    if (report.converged || !std::isfinite(ratio) || report.iterations == max_iterations) break;
    if (!factor_jacobian(workspace)) break;
    solve_correction(workspace);
    const Eigen::VectorXd& c = workspace.correction;
    const double rounding = kRounding * workspace.unknowns.norm();
    report.converged = c.norm() <= rounding;
    if (report.converged) break;
    const double slope = -workspace.residual.dot(c);
    const double bend = -slope - workspace.shift * c.squaredNorm();
    double length = 1.0;  // of the correction, as a fraction of c
    workspace.unknowns -= c;
    double next = evaluate();
    // Far out the numbers may overflow: come back until they do not.
    while (!std::isfinite(next) && length > 1e-6) {
      workspace.unknowns += 0.9 * length * c;
      length *= 0.1;
      next = evaluate();
    }
    if (next > 1.0 && !(next < 0.9 * ratio)) {
      workspace.image.noalias() = workspace.jacobian * c;
      const double best =
          first_zero(length, slope, bend, -workspace.residual.dot(c), c.dot(workspace.image));
      if (best != length) {
        workspace.unknowns += (length - best) * c;
        next = evaluate();
      }
    }
    ratio = next;
  }
  report.residual = workspace.residual.norm();
  return report;
}

// size / (tolerance * scale); 0 where nothing moves and nothing pushes.
inline double relative_size(double size, double tolerance, double scale) {
  return size == 0.0 ? 0.0 : size / (tolerance * scale);
}

}  // namespace tremolo
