// Follows a curve of periodic motions from a first state to an end: steps, harmonics, folds,
// stability.
#pragma once

#include <functional>

#include "runtime/response/motion_equations.h"
#include "runtime/response/response.h"

namespace tremolo {

// Where a curve ends.
struct CurveGoal {
  // Negative before the requested end and positive behind it.
  std::function<double(const CurvePoint&)> beyond;
  // True if the curve has left its range by the other side. May be empty.
  std::function<bool(const CurvePoint&)> returned;
};

// first: the unknowns of a solution; direction: where to go, in the unknowns (curve_state).
// conservative: a free motion without damping, which has two multipliers at +1.
Result<MotionCurve> trace_curve(MotionEquations& equations, const VibratingSystem& system,
                                Eigen::VectorXd first, const Eigen::VectorXd& direction,
                                const CurveGoal& goal, bool conservative,
                                const CurveOptions& options);

}  // namespace tremolo
