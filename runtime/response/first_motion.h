// The motion with which a response curve begins: at one frequency, under the load that grows from
// nothing.
#pragma once

#include "runtime/response/response.h"

namespace tremolo {

// A periodic force at one frequency.
struct FirstMotionRequest {
  const VibratingSystem& system;
  const FourierSeries& force;   // r x (2K + 1), N kg^-1/2
  const Eigen::VectorXd& rest;  // the static state under its constant part, r
  double omega = 0.0;           // rad/s
  double omega_scale = 0.0;     // rad/s, MotionEquations
};

// The motion that grows out of rest with the load, r x (2H + 1) with H from options.harmonics to
// options.most_harmonics. Large parts of the load are tried first. Near a resonance the motion over
// the load turns back, and its curve is followed until the whole load acts. Errors: kSolver if it
// was not found.
Result<FourierSeries> first_motion(const FirstMotionRequest& request, const CurveOptions& options);

}  // namespace tremolo
