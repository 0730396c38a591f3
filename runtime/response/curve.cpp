#include "runtime/response/curve.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

constexpr int kMostCorrections = 24;
constexpr int kMostFactorizations = 8;
constexpr double kSlowContraction = 0.2;  // of one correction with an old factor
constexpr int kMostEvaluations = 40;      // of find_zero

// The matrix [g'; border] at y.
Eigen::MatrixXd bordered(CurveEquations& equations, const Eigen::VectorXd& y,
                         const Eigen::VectorXd& border) {
  const Eigen::Index n = equations.unknowns();
  Eigen::MatrixXd matrix(n, n);
  equations.jacobian(y, matrix);
  matrix.row(n - 1) = border.transpose();
  return matrix;
}

int sign_of(const Eigen::PartialPivLU<Eigen::MatrixXd>& factor) {
  int sign = static_cast<int>(factor.permutationP().determinant());
  const auto diagonal = factor.matrixLU().diagonal();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (diagonal[i] < 0.0) sign = -sign;
  return sign;
}

// One corrector: iterates from y until the last correction is below `tolerance` of the state.
struct Corrector {
  CurveEquations& equations;
  const Eigen::VectorXd& border;
  const Eigen::VectorXd& weights;
  double tolerance;

  // factor: an old one to begin with, or null.
  CorrectorReport run(const Eigen::PartialPivLU<Eigen::MatrixXd>* factor, Eigen::VectorXd& y) {
    const Eigen::Index n = y.size();
    const Eigen::VectorXd plane = y;
    Eigen::PartialPivLU<Eigen::MatrixXd> own;
    Eigen::VectorXd residual(n - 1), right(n);
    CorrectorReport report;
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
      if (length < tolerance || (length < kCurveTolerance && length >= before)) {
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
  state.sign = sign_of(state.factor);
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
  return Corrector{equations, from.border, from.weights, tolerance}.run(
      sharp ? nullptr : &from.factor, y);
}

Result<CurveState> find_zero(CurveEquations& equations, const CurveState& from, double ds,
                             double at_start, double at_end, const CurveFunction& function) {
  double low = 0.0, high = ds, f_low = at_start, f_high = at_end;
  Result<CurveState> state = from;
  const Eigen::VectorXd direction = (from.weights.array().square() * from.tangent.array()).matrix();
  for (int i = 0; i < kMostEvaluations; ++i) {
    // The secant's zero, kept off the ends so that the bracket shrinks (the Illinois rule below).
    double s = (low * f_high - high * f_low) / (f_high - f_low);
    if (!std::isfinite(s) || i % 8 == 7) s = 0.5 * (low + high);
    Eigen::VectorXd y;
    if (!advance(equations, from, s, true, y).converged)
      return Error{ErrorKind::kSolver, "a point of the curve was not found"};
    state = curve_state(equations, std::move(y), direction);
    if (!state) return state;
    const double f = function(*state);
    if (f == 0.0) return state;
    if ((f > 0.0) == (f_low > 0.0)) {
      low = s, f_low = f;
      f_high *= 0.5;
    } else {
      high = s, f_high = f;
      f_low *= 0.5;
    }
    if (std::abs(f) < 1e-11 || std::abs(high - low) < 1e-12 * std::abs(ds)) return state;
  }
  return state;
}

}  // namespace tremolo
