// The motion of a curve with a given amplitude.
#include "runtime/response/orbit.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/response/backbone.h"
#include "tests/response/oscillators.h"

namespace tremolo {
namespace {

TEST(Orbit, OfAnyAmplitudeIsAMotionOfTheOscillator) {
  const Duffing duffing{2.0, 1.0, 0.0};
  CurveOptions options = plain_options(9);
  options.longest_step = 0.05;
  const MotionCurve curve = *backbone_curve(system_of(duffing), {0, {}, 2.0}, options);
  for (const double amplitude : {0.3, 0.77, 1.31, 2.0}) {
    const CurvePoint point = at_amplitude(curve, amplitude);
    // The curve ends there to the tolerance of its end.
    EXPECT_NEAR(point.amplitude, amplitude, 1e-11);
    const State start = orbit_state(point, 0.0);
    // Linear between points that are 5 % apart: an error of 0.05^2/8 of a curve of unit curvature.
    EXPECT_NEAR(std::abs(start.q[0]), amplitude, 1e-3 * amplitude);
    const Shot shot = shoot(duffing, 0.0, point.omega, {start.q[0], start.p[0]});
    EXPECT_NEAR(shot.end[0], start.q[0], 2e-3 * amplitude);
    EXPECT_NEAR(shot.end[1], start.p[0], 2e-2 * amplitude);
  }
}

TEST(Orbit, OfASmallAmplitudeIsTheScaledFirstOneAndBeyondTheCurveTheLargest) {
  const Duffing duffing{2.0, 1.0, 0.0};
  const MotionCurve curve = *backbone_curve(system_of(duffing), {0, {}, 1.0}, plain_options(5));
  const CurvePoint& first = curve.points.front();
  const CurvePoint small = at_amplitude(curve, 0.5 * first.amplitude);
  EXPECT_LE((small.motion - 0.5 * first.motion).norm(), 1e-15);
  EXPECT_EQ(small.omega, first.omega);
  EXPECT_EQ(at_amplitude(curve, 7.0).amplitude, curve.points.back().amplitude);
}

TEST(Orbit, ItsStateIsTheSeriesAndItsDerivative) {
  CurvePoint point;
  point.omega = 3.0;
  point.motion = FourierSeries::Zero(1, 5);
  point.motion << 0.5, 1.0, 2.0, 0.0, 4.0;  // 0.5 + cos + 2 sin + 4 sin 2
  const double t = 0.7;
  const State state = orbit_state(point, t);
  EXPECT_NEAR(state.q[0], 0.5 + std::cos(t) + 2.0 * std::sin(t) + 4.0 * std::sin(2.0 * t), 1e-14);
  EXPECT_NEAR(state.p[0], 3.0 * (-std::sin(t) + 2.0 * std::cos(t) + 8.0 * std::cos(2.0 * t)),
              1e-13);
}

}  // namespace
}  // namespace tremolo
