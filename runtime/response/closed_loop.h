// Finds out whether a curve has come back onto itself. A regular curve that passes one of its own
// points in the same direction is closed: from there on it repeats itself.
#pragma once

#include <optional>

#include "runtime/response/equations/motion_equations.h"
#include "runtime/response/response.h"

namespace tremolo {

// The point of the curve (its number) that the step from `from`, the state at the last point, to
// `next` passes in the direction that the curve had there. The two are the same solution of the
// equations: motions that are only near do not count.
std::optional<std::size_t> point_passed_again(MotionEquations& equations, const MotionCurve& curve,
                                              const CurveState& from, const CurveState& next);

}  // namespace tremolo
