// The stable points of a response curve by time stepping, for comparison.
//
// It goes from point to point as a slow sweep does, with the default method, and starts each point
// in the state where the one before has settled. A point has settled when the rest of its transient
// is 1e-4 of the motion. The transient decays by the curve's largest Floquet multiplier mu per
// period, so that the rest is the change over the last period divided by |1 - mu|. Without the
// curve a user does not know mu and steps longer. The step is the longest one, of a period over a
// power of two, that gives the amplitude of the largest stable point away from folds to 1e-4.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/integrator.h"
#include "runtime/model.h"
#include "runtime/response/response.h"

namespace tremolo {

// The body of a response curve.
struct SteppedLoad {
  Model::Pointer model;
  IntegratorOptions damping;   // of which the step is not read
  Eigen::VectorXd periodic;    // times sin omega t, r
  Eigen::VectorXd constant;    // r
  Eigen::MatrixXd probe_rows;  // 3 x r
  // Displacement of the probe by the forces themselves: times sin omega t, and constant, m.
  Eigen::Vector3d probe_periodic = Eigen::Vector3d::Zero();
  Eigen::Vector3d probe_constant = Eigen::Vector3d::Zero();
};

struct SteppedCurve {
  double seconds = 0.0;     // processor time of the points, without the choice of the step
  int points = 0;           // stable ones
  int elsewhere = 0;        // those that settled onto another motion, or not in 1000 periods
  double periods = 0.0;     // of all points
  int steps = 0;            // a period
  double difference = 0.0;  // largest, of amplitudes from the curve's, relative
};

// direction: 1 if the curve was followed to higher frequencies, else -1. Its points must have
// multipliers, of all steps (floquet_steps) where stiff coordinates are to settle. Errors: kSolver
// if no point is stable; those of steps.
Result<SteppedCurve> step_curve(const SteppedLoad& load, const MotionCurve& curve,
                                double direction);

}  // namespace tremolo
