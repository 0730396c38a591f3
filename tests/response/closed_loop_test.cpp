// Curves that come back onto themselves.
#include "runtime/response/closed_loop.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "runtime/response/backbone.h"
#include "runtime/response/curve_tracer.h"
#include "tests/response/oscillators.h"

namespace tremolo {
namespace {

// The subharmonic motions of a Duffing oscillator, a third of the load's frequency, are a closed
// curve over it: both ends are folds, and no part of it leads anywhere else.
TEST(ClosedLoop, ACurveThatComesBackOntoItselfEnds) {
  const Duffing duffing{1.0, 1.0, 0.002};
  const VibratingSystem system = system_of(duffing);
  FourierSeries force = FourierSeries::Zero(1, 7);
  force(0, cosine_column(3)) = 3.0;
  CurveOptions options = plain_options(9);
  const double omega = 1.4;
  ForcedEquations equations(system, force, 9, 1.0, omega);
  // cos(omega t + phase) beside the forced motion of harmonic 3.
  Eigen::VectorXd y;
  bool found = false;
  for (int n = 0; n < 24 && !found; ++n) {
    const double phase = 2.0 * std::numbers::pi * n / 24.0, size = 0.3 + 0.2 * (n % 4);
    FourierSeries guess = FourierSeries::Zero(1, 19);
    guess(0, 1) = size * std::cos(phase);
    guess(0, 2) = size * std::sin(phase);
    guess(0, cosine_column(3)) = 3.0 / (1.0 - 9.0 * omega * omega);
    y = equations.unknowns_of(guess, omega);
    const Eigen::VectorXd border = Eigen::VectorXd::Unit(y.size(), y.size() - 1);
    found = solve_on_border(equations, border, kCurveTolerance, y).converged &&
            equations.motion(y).middleCols(1, 2).norm() > 0.1;
  }
  ASSERT_TRUE(found);
  CurveGoal goal;
  goal.beyond = [](const CurvePoint& point) { return point.omega - 100.0; };
  const Result<MotionCurve> curve = trace_curve(
      equations, system, y, Eigen::VectorXd::Unit(y.size(), y.size() - 1), goal, false, options);
  ASSERT_TRUE(curve) << curve.error().message;
  EXPECT_EQ(curve->end, CurveEnd::kLoop);
  EXPECT_LT(curve->loop_start, 3U);
  int folds = 0;
  for (const Bifurcation& at : curve->bifurcations)
    folds += at.kind == BifurcationKind::kFold ? 1 : 0;
  EXPECT_EQ(folds, 2);
  EXPECT_GT(curve->points.size(), 20U);
  // Every point is a subharmonic motion: it moves at a third of the load's frequency.
  for (const CurvePoint& point : curve->points)
    EXPECT_GT(point.motion.middleCols(1, 2).norm(), 1e-2);
}

// Free motions have any phase: a step that repeats one of the curve's, at another time, is found.
TEST(ClosedLoop, AFreeMotionThatIsPassedAgainIsFoundAtAnyPhase) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.0}), other = system_of({1.0, 1.1, 0.0});
  const CurveOptions options = plain_options(7);
  const Result<MotionCurve> curve = backbone_curve(system, {0, {}, 2.0}, options);
  ASSERT_TRUE(curve);
  ASSERT_GT(curve->points.size(), 30U);
  const auto passed = [&](const VibratingSystem& of, double shift, int i, int to) {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(1);
    FreeEquations equations(of, none, 7, 1e-3, 1.0);
    const auto state_at = [&](int point) {
      const CurvePoint& at = curve->points[static_cast<std::size_t>(point)];
      Eigen::VectorXd y = equations.unknowns_of(shifted(at.motion, shift), at.omega);
      equations.refer_to(y);
      const Eigen::VectorXd direction = (to - i) * equations.unknowns_of(equations.motion(y), 0.0);
      EXPECT_TRUE(solve_on_border(equations, direction, kSharpTolerance, y).converged);
      return curve_state(equations, std::move(y), direction);
    };
    const Result<CurveState> from = state_at(i), next = state_at(to);
    return point_passed_again(equations, *curve, *from, *next);
  };
  // The motion is small at first, and all oscillators are one there.
  const int at = static_cast<int>(curve->points.size()) - 15;
  for (const double shift : {0.0, 1.0, 4.0}) {
    const auto again = passed(system, shift, at, at + 2);
    ASSERT_TRUE(again) << shift;
    EXPECT_GE(static_cast<int>(*again), at);
    EXPECT_LE(static_cast<int>(*again), at + 2);
    EXPECT_FALSE(passed(system, shift, at + 2, at));  // backwards
    EXPECT_FALSE(passed(other, shift, at, at + 2));   // a curve that is only near
  }
}

}  // namespace
}  // namespace tremolo
