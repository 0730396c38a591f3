// Past an internal resonance of 1:2 on a backbone.
//
// A mode's backbone may end there on that of a mode of twice the frequency: its odd harmonics
// vanish, and beyond it would repeat itself half a period later. On the other mode's backbone this
// is a period doubling. That backbone is unstable up to a second period doubling, from which the
// first mode's backbone continues on the other side of the resonance.
#pragma once

#include <optional>

#include "runtime/response/curve_tracer.h"

namespace tremolo {

// The free motions that a backbone consists of.
struct FreeMotions {
  const VibratingSystem& system;  // without damping
  Eigen::VectorXd constant;       // the constant force, r
  Eigen::VectorXd rest;           // the static state under it, r
  double least_size = 0.0;        // FreeEquations
  double omega_scale = 0.0;       // rad/s
};

// The curve from the last point of one that has joined (CurveEnd::kJoined): first the part of the
// other mode's backbone, with twice its period, then the other side. Empty if there is none up to
// the goal. Replaces the last point of `joined` by a solution.
std::optional<MotionCurve> past_half_period(const FreeMotions& free, const CurveGoal& goal,
                                            const CurveOptions& options, MotionCurve& joined);

}  // namespace tremolo
