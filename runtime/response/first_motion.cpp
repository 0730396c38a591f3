#include "runtime/response/first_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/text.h"
#include "runtime/response/curve_tracer.h"

namespace tremolo {
namespace {

// Newton's method under the growing load, from the linear motion on. Empty: a part of the load that
// is not small gave no motion.
std::optional<FourierSeries> by_growing_load(const FirstMotionRequest& by, Eigen::Index harmonics) {
  constexpr double kLeastPart = 0.1;
  FourierSeries part_of_force = by.force;
  FourierSeries motion = with_harmonics(by.rest, harmonics);
  double done = 0.0, part = 1.0;
  while (done < 1.0) {
    const double next = std::min(1.0, done + part);
    part_of_force.rightCols(by.force.cols() - 1) = next * by.force.rightCols(by.force.cols() - 1);
    Result<FourierSeries> guess = FourierSeries(motion);
    if (done == 0.0) guess = linear_motion(by.system, by.rest, part_of_force, by.omega, harmonics);
    if (!guess) return std::nullopt;
    ForcedEquations equations(by.system, part_of_force, harmonics, vibration_size(*guess, by.rest),
                              by.omega_scale);
    equations.set_rest(by.rest);
    Eigen::VectorXd y = equations.unknowns_of(*guess, by.omega);
    const Eigen::VectorXd border = Eigen::VectorXd::Unit(y.size(), y.size() - 1);
    if (solve_on_border(equations, border, kCurveTolerance, y).converged) {
      motion = equations.motion(y);
      done = next;
      part *= 1.5;
      continue;
    }
    part *= 0.5;
    if (part < kLeastPart) return std::nullopt;
  }
  return motion;
}

// True if the force half a period later is the opposite one.
bool has_odd_harmonics_only(const FourierSeries& force) {
  FourierSeries even = force - odd_harmonics(force);
  even.col(0).setZero();
  return even.isZero(0.0);
}

// The curve of motions over the load, through its folds, from the linear motion under little load
// to that under the whole one. Without damping it may pass through zero to the opposite load, under
// which the motion is the same half a period later.
Result<FourierSeries> by_following_load(const FirstMotionRequest& by, const CurveOptions& options) {
  constexpr double kFirstLoad = 1e-3, kLeastLoad = 1e-9;
  constexpr int kMostPoints = 1000;
  const Error none{
      ErrorKind::kSolver,
      "no periodic motion was found at the first frequency; begin further away from the resonance"};
  CurveOptions path = options;
  path.stability = false;
  path.most_points = kMostPoints;
  const bool odd = has_odd_harmonics_only(by.force);
  CurveGoal goal;
  goal.events = false;
  goal.beyond = [=](const CurvePoint& point) {
    return (odd ? std::abs(point.load) : point.load) - 1.0;
  };
  for (double load = kFirstLoad; load > kLeastLoad; load *= 0.1) {
    FourierSeries force = by.force;
    force.rightCols(force.cols() - 1) *= load;
    const Result<FourierSeries> guess =
        linear_motion(by.system, by.rest, force, by.omega, options.harmonics);
    if (!guess) return guess.error();
    LoadEquations equations(by.system, by.force, options.harmonics, by.omega,
                            vibration_size(*guess, by.rest), by.omega_scale);
    equations.set_rest(by.rest);
    Eigen::VectorXd y = equations.unknowns_of(*guess, by.omega, load);
    const Eigen::VectorXd border = Eigen::VectorXd::Unit(y.size(), y.size() - 2);
    if (!solve_on_border(equations, border, kCurveTolerance, y).converged) continue;
    const Result<MotionCurve> curve =
        trace_curve(equations, by.system, std::move(y), border, goal, false, path);
    if (curve && curve->end == CurveEnd::kUnbounded)
      return Error{ErrorKind::kSolver,
                   "under " + number_text(std::abs(curve->points.back().load)) +
                       " of the load the motion at the first frequency is above the largest "
                       "amplitude; use a smaller load or more damping"};
    if (!curve || curve->end != CurveEnd::kDone) return none;
    const CurvePoint& last = curve->points.back();
    return last.load > 0.0 ? last.motion : shifted(last.motion, std::numbers::pi);
  }
  return none;
}

}  // namespace

Result<FourierSeries> first_motion(const FirstMotionRequest& request, const CurveOptions& options) {
  if (std::optional<FourierSeries> motion = by_growing_load(request, options.harmonics))
    return *std::move(motion);
  Result<FourierSeries> followed = by_following_load(request, options);
  // The equations of few harmonics may have no motion there that grows out of the linear one.
  for (Eigen::Index H = options.harmonics + 2; !followed && H <= options.most_harmonics; H += 2)
    if (std::optional<FourierSeries> motion = by_growing_load(request, H))
      return *std::move(motion);
  return followed;
}

}  // namespace tremolo
