#include "runtime/response/equations/curve.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

constexpr int kMostCorrections = 24;
constexpr int kMostFactorizations = 8;
constexpr double kSlowContraction = 0.2;  // of one correction with an old factor
// Of find_zero: evaluations, and the value and the part of the step that count as zero.
constexpr int kMostEvaluations = 40;
constexpr double kZeroValue = 1e-11, kZeroLength = 1e-12;

// The matrix [g'; border] at y.
Eigen::MatrixXd bordered(CurveEquations& equations, const Eigen::VectorXd& y,
                         const Eigen::VectorXd& border) {
  const Eigen::Index n = equations.unknowns();
  Eigen::MatrixXd matrix(n, n);
  equations.jacobian(y, matrix);
  matrix.row(n - 1) = border.transpose();
  return matrix;
}

// One corrector: iterates from y until the last correction is below `tolerance` of the state.
struct Corrector {
  CurveEquations& equations;
  const Eigen::VectorXd& border;
  const Eigen::VectorXd& weights;
  double tolerance;

  // factor: an old one to begin with, or null.
  CorrectorReport run(const DenseLu* factor, Eigen::VectorXd& y) {
    const Eigen::Index n = y.size();
    const Eigen::VectorXd plane = y;
    DenseLu own;
    Eigen::VectorXd residual(n - 1), right(n);
    CorrectorReport report;
    const double coarse = equations.coarseness(y);
    double before = INFINITY;
    while (report.corrections < kMostCorrections) {
      if (factor == nullptr) {
        if (++report.factorizations > kMostFactorizations) return report;
        own.compute(bordered(equations, y, border));
        factor = &own;
      }
      equations.residual(y, residual);
      right.head(n - 1) = -residual;
      right[n - 1] = -border.dot(y - plane);
      const Eigen::VectorXd correction = factor->solve(right);
      const double length = (weights.array() * correction.array()).matrix().norm();
      if (!std::isfinite(length) || length > 1e3) return report;
      y += correction;
      ++report.corrections;
      if (length < coarse * tolerance || (length < coarse * kCurveTolerance && length >= before)) {
        report.converged = true;
        return report;
      }
      // Newton's own steps may be long at first; those with an old factor must contract.
      if (length > kSlowContraction * before || (factor != &own && length > 1.0)) factor = nullptr;
      if (factor == &own && length > 1e-3) factor = nullptr;
      before = length;
    }
    return report;
  }
};

}  // namespace

Result<CurveState> curve_state(CurveEquations& equations, Eigen::VectorXd y,
                               const Eigen::VectorXd& direction) {
  CurveState state;
  state.weights = equations.weights(y);
  state.border = direction / (direction.array() / state.weights.array()).matrix().norm();
  equations.refer_to(y);
  state.factor.compute(bordered(equations, y, state.border));
  state.y = std::move(y);
  const Eigen::Index n = state.y.size();
  state.tangent = state.factor.solve(Eigen::VectorXd::Unit(n, n - 1));
  const double length = (state.weights.array() * state.tangent.array()).matrix().norm();
  if (!(length > 0.0) || !std::isfinite(length))
    return Error{ErrorKind::kSolver, "the equations are singular there"};
  state.tangent /= length;
  state.sign = state.factor.sign();
  // One correction with the new factor takes what the corrector has left.
  Eigen::VectorXd residual, right = Eigen::VectorXd::Zero(n);
  equations.residual(state.y, residual);
  right.head(n - 1) = -residual;
  state.y += state.factor.solve(right);
  return state;
}

CorrectorReport solve_on_border(CurveEquations& equations, const Eigen::VectorXd& border,
                                double tolerance, Eigen::VectorXd& y) {
  const Eigen::VectorXd weights = equations.weights(y);
  return Corrector{equations, border, weights, tolerance}.run(nullptr, y);
}

CorrectorReport advance(CurveEquations& equations, const CurveState& from, double ds, bool sharp,
                        Eigen::VectorXd& y) {
  equations.refer_to(from.y);
  y = from.y + ds * from.tangent;
  const double tolerance = sharp ? kSharpTolerance : kCurveTolerance;
  return Corrector{equations, from.border, from.weights, tolerance}.run(&from.factor, y);
}

// Chandrupatla (1997): inverse quadratic interpolation where three points allow it, else halves.
Result<Eigen::VectorXd> find_zero(CurveEquations& equations, const CurveState& from, double ds,
                                  double at_start, double at_end, const CurveFunction& function) {
  // The zero is between a, the newest point, and b; c was left out last.
  double a = 0.0, b = ds, c = 0.0, f_a = at_start, f_b = at_end, f_c = at_start;
  double t = f_a / (f_a - f_b);
  Eigen::VectorXd y;
  for (int i = 0; i < kMostEvaluations; ++i) {
    const double x = a + t * (b - a);
    if (!advance(equations, from, x, true, y).converged) {
      // A branch point may be there, at which the equations are singular.
      if (t == 0.5) return Error{ErrorKind::kSolver, "a point of the curve was not found"};
      t = 0.5;
      continue;
    }
    const double f = function(y);
    if (!std::isfinite(f))
      return Error{ErrorKind::kSolver, "the curve is singular near one of its points"};
    if ((f > 0.0) == (f_a > 0.0)) {
      c = a, f_c = f_a;
    } else {
      c = b, f_c = f_b;
      b = a, f_b = f_a;
    }
    a = x, f_a = f;
    const double least = kZeroLength * std::abs(ds) / std::abs(b - a);
    if (std::abs(f) < kZeroValue || least > 0.5) return y;
    const double xi = (a - b) / (c - b), phi = (f_a - f_b) / (f_c - f_b);
    const bool smooth = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
    t = smooth ? f_a / (f_b - f_a) * f_c / (f_b - f_c) +
                     (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
               : 0.5;
    t = std::clamp(t, least, 1.0 - least);
  }
  return y;
}

}  // namespace tremolo
