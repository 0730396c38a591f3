// Newton's method for the equation of one implicit step, in preallocated storage.
//
// The residual g of every implicit method here is the gradient of a functional of the unknowns (so
// the Jacobian J is symmetric), and for a quartic V that functional is a quartic along any line. A
// correction c that solves J c = g is used whole where it lowers |g|. Otherwise the slope -g(x - t
// c).c, a cubic in t known from its values and derivatives at both ends, is solved for its first
// zero: an exact line search without another evaluation. An indefinite Jacobian is shifted to a
// nearby positive definite one, so that c is always a descent direction.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Core>

#include "runtime/integrator.h"
#include "runtime/math/dense/small_matrices.h"

namespace tremolo {

inline constexpr int kUpdates = 8;  // Broyden's, then the exact Jacobian

// Unknowns and scratch of a solve.
struct NewtonWorkspace {
  explicit NewtonWorkspace(Eigen::Index n);

  Eigen::VectorXd unknowns;  // n
  Eigen::VectorXd residual;  // n
  // d residual / d unknowns, n x n, symmetric, both triangles filled.
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd correction;  // n
  Eigen::VectorXd jacobian_c;  // jacobian * correction
  SmallCholesky cholesky;
  std::array<Eigen::VectorXd, kUpdates> moves;  // of solve_frozen
  Eigen::VectorXd start;                        // unknowns at its start
  // Cholesky is a factor of solve_frozen's, of this jacobian or an earlier one.
  bool frozen = false;
  double shift = 0.0;  // added to the Jacobian's diagonal before it was factored
};

// Factors the Jacobian, shifted if it is not positive definite. False if it is not finite.
bool factor_jacobian(NewtonWorkspace& workspace);

// correction = (jacobian + shift)^-1 residual, by the last factor.
void solve_correction(NewtonWorkspace& workspace);

// In: move = -J^-1 g by a Jacobian that was frozen before the first of the moves so far. Out: the
// move by Broyden's updates after all of them (Kelley 1995, chapter 7, without their matrix).
// moves: the moves so far.
void apply_broyden(std::span<const Eigen::VectorXd> moves, Eigen::VectorXd& move);

// The first zero in (0, 4 end], 4 end if there is none, of the cubic s with s(0) = slope0 < 0,
// s'(0) = bend0, s(end) = slope1, s'(end) = bend1.
double first_zero(double end, double slope0, double bend0, double slope1, double bend1);

// Broyden's updates count as slow where a residual falls by less than this factor.
inline constexpr double kSlow = 0.6;

// Rounding error of the unknowns, relative: a few units in the last place.
inline constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();

// Moves the unknowns along minus the correction c of the present residual g and Jacobian: by c
// where that lowers the residual, else to the first zero of the slope. evaluate(): as below. ratio:
// its value at the start. Returns its value at the end.
template <class Evaluate>
double search_line(NewtonWorkspace& workspace, double ratio, Evaluate&& evaluate) {
  const Eigen::VectorXd& c = workspace.correction;
  const double slope0 = -workspace.residual.dot(c);
  const double bend0 = -slope0 - workspace.shift * c.squaredNorm();
  double length = 1.0;  // of the correction, as a fraction of c
  workspace.unknowns -= c;
  double next = evaluate();
  // Far out the numbers may overflow: the move is shortened until they do not.
  while (!std::isfinite(next) && length > 1e-6) {
    workspace.unknowns += 0.9 * length * c;
    length *= 0.1;
    next = evaluate();
  }
  if (!(next > 1.0) || next < 0.9 * ratio) return next;
  workspace.jacobian_c.noalias() = workspace.jacobian * c;
  const double slope1 = -workspace.residual.dot(c), bend1 = c.dot(workspace.jacobian_c);
  const double best = first_zero(length, slope0, bend0, slope1, bend1);
  if (best == length) return next;
  workspace.unknowns += (length - best) * c;
  return evaluate();
}

// Corrects workspace.unknowns until the residual is small enough, at most max_iterations times.
// evaluate(): fills residual and jacobian for the present unknowns and returns the residual's size
// divided by its limit, so that <= 1 is convergence. A correction below the rounding error of the
// unknowns is convergence too, because h^2 omega^2 may lift the residual's rounding error above any
// tolerance. The report's residual is the Euclidean norm.
template <class Evaluate>
StepReport solve_newton(NewtonWorkspace& workspace, int max_iterations, Evaluate&& evaluate) {
  StepReport report;
  double ratio = evaluate();
  for (;; ++report.iterations) {
    report.converged = ratio <= 1.0;  // false for NaN
    if (report.converged || !std::isfinite(ratio) || report.iterations == max_iterations) break;
    if (!factor_jacobian(workspace)) break;
    solve_correction(workspace);
    report.converged = workspace.correction.norm() <= kRounding * workspace.unknowns.norm();
    if (report.converged) break;
    ratio = search_line(workspace, ratio, evaluate);
  }
  report.residual = workspace.residual.norm();
  return report;
}

// The same with the Jacobian of the first evaluation and Broyden's updates: evaluate(false) need
// not fill it, which is cheaper. If that does not converge, solve_newton() runs from the start.
template <class Evaluate>
StepReport solve_frozen(NewtonWorkspace& workspace, int max_iterations, Evaluate&& evaluate) {
  workspace.start = workspace.unknowns;
  const bool had_factor = workspace.frozen;
  workspace.frozen = false;
  double ratio = evaluate(true);
  StepReport report;
  report.converged = ratio <= 1.0;
  bool usable = !report.converged && std::isfinite(ratio) && factor_jacobian(workspace) &&
                workspace.shift == 0.0;
  const int most = std::min(kUpdates, max_iterations);
  for (int slow = 0; usable && !report.converged && slow < 2 && report.iterations < most;
       ++report.iterations) {
    const std::span<Eigen::VectorXd> moves(workspace.moves);
    const std::size_t count = report.iterations;
    workspace.correction = -workspace.residual;
    workspace.cholesky.solve(workspace.correction);
    apply_broyden(moves.first(count), workspace.correction);
    moves[count] = workspace.correction;
    report.converged = moves[count].norm() <= kRounding * workspace.unknowns.norm();
    if (report.converged) break;
    workspace.unknowns += moves[count];
    const double next = evaluate(false);
    usable = std::isfinite(next);
    if (!(next < kSlow * ratio)) ++slow;
    ratio = next;
    report.converged = ratio <= 1.0;
  }
  report.residual = workspace.residual.norm();
  workspace.frozen = report.converged && (report.iterations > 0 || had_factor);
  if (report.converged) return report;
  const int before = report.iterations;
  workspace.unknowns = workspace.start;
  report = solve_newton(workspace, max_iterations, [&] { return evaluate(true); });
  report.iterations += before;
  return report;
}

// The size of a residual g relative to its limit, tolerance max(h |p|, h^2 |R|, h^2 |f|); 0 without
// motion and forces. g, p, R, f: norms.
inline double relative_residual(double g, double tolerance, double h, double p, double R,
                                double f) {
  return g == 0.0 ? 0.0 : g / (tolerance * std::max({h * p, h * h * R, h * h * f}));
}

}  // namespace tremolo
