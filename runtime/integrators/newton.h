// Newton's method for the equation of one implicit step, in storage that is made once.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

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
  Eigen::LLT<Eigen::MatrixXd> cholesky;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
};

// correction = jacobian^-1 residual. Cholesky; LU where the Jacobian is indefinite, as happens
// under strong compression at a large step.
void solve_correction(NewtonWorkspace& workspace);

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
  for (;; ++report.iterations) {
    const double ratio = evaluate();
    report.converged = ratio <= 1.0;  // false for NaN
    if (report.converged || !std::isfinite(ratio) || report.iterations == max_iterations) break;
    solve_correction(workspace);
    const double rounding = kRounding * workspace.unknowns.norm();
    report.converged = workspace.correction.norm() <= rounding;
    if (report.converged) break;
    workspace.unknowns -= workspace.correction;
  }
  report.residual = workspace.residual.norm();
  return report;
}

// size / (tolerance * scale); 0 where nothing moves and nothing pushes.
inline double relative_size(double size, double tolerance, double scale) {
  return size == 0.0 ? 0.0 : size / (tolerance * scale);
}

}  // namespace tremolo
