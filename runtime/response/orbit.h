// The motion of a point of a curve, and the point of a curve with a given amplitude.
#pragma once

#include "runtime/math/state.h"
#include "runtime/response/response.h"

namespace tremolo {

// The state of the motion at the angle theta, rad; a period is 2 pi.
State orbit_state(const CurvePoint& point, double theta);

// The motion where the curve first reaches the amplitude (in the unit of CurveOptions::amplitude),
// between the two neighbouring points: motion and frequency are linear between them. Below the
// first point its motion is scaled; above the largest amplitude that point is the result. The curve
// must have a point. stable, multipliers and share are those of the nearer point.
CurvePoint at_amplitude(const MotionCurve& curve, double amplitude);

}  // namespace tremolo
