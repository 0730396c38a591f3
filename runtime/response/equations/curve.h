// Pseudo-arclength continuation of a curve of solutions: m equations g(y) = 0 for m + 1 unknowns.
//
// The length along the curve is measured in scaled unknowns, ds^2 = sum (w_i dy_i)^2. From a state
// y with the unit tangent t, the predictor is y + ds t, and the corrector solves
//
//     g(y') = 0,      b . (y' - y - ds t) = 0
//
// with the border b that the state's matrix [g'; b] was factored with. Corrections reuse that
// factor while they contract, so that a point usually costs one factorization.
#pragma once

#include <functional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/dense/dense_lu.h"

namespace tremolo {

// The equations of a curve.
class CurveEquations {
 public:
  virtual ~CurveEquations() = default;
  virtual Eigen::Index unknowns() const = 0;  // m + 1; the last one is the angular frequency
  // out: m.
  virtual void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) = 0;
  // Sets the first m rows of out, (m + 1) x (m + 1).
  virtual void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) = 0;
  // The weights w of the length at y, m + 1, all positive.
  virtual Eigen::VectorXd weights(const Eigen::VectorXd& y) const = 0;
  // The factor of all tolerances, 1 or more: a solution cannot be nearer than rounding, which may
  // be large beside the sizes of weights().
  virtual double coarseness(const Eigen::VectorXd& y) const { return (void)y, 1.0; }
  // The solution that a condition on the phase refers to from now on.
  virtual void refer_to(const Eigen::VectorXd& y) { (void)y; }
};

// A solution with its tangent.
struct CurveState {
  Eigen::VectorXd y;        // m + 1
  Eigen::VectorXd tangent;  // m + 1, of length 1 in the weights
  Eigen::VectorXd weights;  // m + 1
  Eigen::VectorXd border;   // m + 1, the last row of the factored matrix
  DenseLu factor;
  int sign = 1;  // of the factored matrix's determinant: it changes at a branch point

  double omega_slope() const { return tangent[tangent.size() - 1]; }
  // The direction of the curve, for curve_state().
  Eigen::VectorXd onwards() const { return weights.array().square() * tangent.array(); }
};

// Result of a correction.
struct CorrectorReport {
  bool converged = false;
  int corrections = 0;
  int factorizations = 0;
};

// Tolerance of a corrector: the last correction relative to the state's size.
inline constexpr double kCurveTolerance = 1e-10;
inline constexpr double kSharpTolerance = 1e-12;

// The state at the solution y; its tangent has a positive product with `direction` (m + 1, not
// zero). Errors: kSolver if the matrix is singular.
Result<CurveState> curve_state(CurveEquations& equations, Eigen::VectorXd y,
                               const Eigen::VectorXd& direction);

// Solves g(y) = 0 and border . (y - y at the call) = 0 by full Newton steps.
CorrectorReport solve_on_border(CurveEquations& equations, const Eigen::VectorXd& border,
                                double tolerance, Eigen::VectorXd& y);

// From the state to the solution at the length ds, negative backwards. sharp: to rounding.
CorrectorReport advance(CurveEquations& equations, const CurveState& from, double ds, bool sharp,
                        Eigen::VectorXd& y);

// The solution between `from` and the length ds at which the function is zero. at_start, at_end:
// its values at both, of opposite signs. Errors: kSolver if a correction fails on the way, or the
// function is not finite.
using CurveFunction = std::function<double(const Eigen::VectorXd& y)>;
Result<Eigen::VectorXd> find_zero(CurveEquations& equations, const CurveState& from, double ds,
                                  double at_start, double at_end, const CurveFunction& function);

}  // namespace tremolo
