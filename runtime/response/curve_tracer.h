// Follows a curve of periodic motions from a first state to an end: steps, harmonics, folds,
// stability.
#pragma once

#include <cmath>
#include <functional>

#include "runtime/response/equations/motion_equations.h"
#include "runtime/response/response.h"

namespace tremolo {

// The end of a curve.
struct CurveGoal {
  // Negative before the requested end and positive behind it.
  std::function<double(const CurvePoint&)> beyond;
  // True if the curve has left its range by the other side. May be empty.
  std::function<bool(const CurvePoint&)> returned;
  // The first point with another number of harmonics, for where it does not follow from the one
  // with fewer. May be empty.
  std::function<Result<Eigen::VectorXd>(Eigen::Index harmonics)> first;
  // True if the curve has all that is needed: it ends as done. May be empty.
  std::function<bool(const MotionCurve&)> enough;
  // The curve ends, as coarse, where the two highest harmonics hold more than this fraction.
  double most_share = INFINITY;
  // Folds and bifurcations are looked for.
  bool events = true;
  // The curve ends, as joined, where the odd harmonics vanish and change their sign: it meets a
  // motion of half the period there and would then repeat itself, half a period later.
  bool ends_at_half_period = false;
};

// first: the unknowns of a solution; direction: where to go, in the unknowns (curve_state).
// conservative: a free motion without damping, which has two multipliers at +1.
Result<MotionCurve> trace_curve(MotionEquations& equations, const VibratingSystem& system,
                                Eigen::VectorXd first, const Eigen::VectorXd& direction,
                                const CurveGoal& goal, bool conservative,
                                const CurveOptions& options);

}  // namespace tremolo
