// Two oscillators near 1:3, V = q1^2/2 + w2^2 q2^2/2 + q1^4/4 + k q1^3 q2 + g q1^2 q2^2: mode 1
// hardens until three times its frequency meets that of mode 2.
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/response/backbone.h"
#include "tests/response/oscillators.h"

namespace tremolo {
namespace {

TEST(InternalResonance, TheLoopOfABackboneAtOneToThreeCloses) {
  const double w2 = 3.05;
  const std::vector<double> cubic(4, 0.0), quartic{0.25, 0.5 / 4.0, 0.5 / 6.0, 0.0, 0.0};
  const VibratingSystem system{*Potential::create(Eigen::Vector2d(1.0, w2 * w2), cubic, quartic),
                               Eigen::Vector2d::Zero(),
                               0.0,
                               {}};
  CurveOptions options = plain_options(9);
  options.longest_step = 0.05;
  const Result<MotionCurve> curve = backbone_curve(system, {0, {}, 1.0}, options);
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  // The third harmonic in mode 2 fills the motion, at a third of that mode's frequency, and empties
  // again: the curve is back on the backbone of mode 1, on the other side of the resonance.
  double most = 0.0, at = 0.0;
  for (const CurvePoint& point : curve->points) {
    const HarmonicPart part = largest_part(point.motion);
    if (part.share > most) most = part.share, at = point.omega;
    if (part.share > 0.05) {
      EXPECT_EQ(part.harmonic, 3);
      EXPECT_EQ(part.coordinate, 1);
    }
  }
  EXPECT_GT(most, 0.99);
  EXPECT_NEAR(at, w2 / 3.0, 1e-3);
  EXPECT_LT(largest_part(curve->points.back().motion).share, 0.01);
  // The two sides differ by the sign of the third harmonic relative to the first.
  const auto sign = [](const CurvePoint& point) {
    return point.motion(0, 1) * point.motion(1, 5) > 0.0;
  };
  EXPECT_NE(sign(curve->points[curve->points.size() / 4]), sign(curve->points.back()));
  std::size_t folds = 0;
  for (const Bifurcation& found : curve->bifurcations)
    folds += found.kind == BifurcationKind::kFold ? 1 : 0;
  EXPECT_EQ(folds, 2U);
}

// Mode 2 alone, q2'' + w2^2 q2 + q2^3 = 0 from q2 = A at rest, over its period T, and the variation
// of q1, x'' + (1 + 2 c q2) x = 0: the trace of the monodromy of x, by Runge-Kutta steps.
double trace_of_variation(double w2, double c, double A, double T) {
  using Rows = Eigen::Matrix<double, 2, 3>;
  const auto slope = [&](const Rows& y) {
    Rows out;
    out.row(0) = y.row(1);
    out(1, 0) = -w2 * w2 * y(0, 0) - std::pow(y(0, 0), 3);
    out.row(1).tail(2) = -(1.0 + 2.0 * c * y(0, 0)) * y.row(0).tail(2);
    return out;
  };
  Rows y;
  y << A, 1.0, 0.0, 0.0, 0.0, 1.0;
  const int steps = 4000;
  const double h = T / steps;
  for (int n = 0; n < steps; ++n) {
    const Rows k1 = slope(y), k2 = slope(y + 0.5 * h * k1), k3 = slope(y + 0.5 * h * k2);
    const Rows k4 = slope(y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  EXPECT_NEAR(y(0, 0), A, 1e-8 * A);  // T is the period
  return y(0, 1) + y(1, 2);
}

// V = q1^2/2 + w2^2 q2^2/2 + c q1^2 q2 + q2^4/4: mode 2 hardens from below 1:2, and the backbone of
// mode 1 joins that of mode 2, along which it reaches the other side.
TEST(InternalResonance, ABackboneContinuesBeyondOneToTwoAlongTheOtherMode) {
  const double w2 = 1.96, c = 0.03;
  const std::vector<double> cubic{0.0, c / 3.0, 0.0, 0.0}, quartic{0.0, 0.0, 0.0, 0.0, 0.25};
  const VibratingSystem system{*Potential::create(Eigen::Vector2d(1.0, w2 * w2), cubic, quartic),
                               Eigen::Vector2d::Zero(),
                               0.0,
                               {}};
  CurveOptions options = plain_options(6);
  options.amplitude = [](const FourierSeries& motion) {
    return largest_over_period(Eigen::RowVector2d(1.0, 0.0), motion).value;
  };
  const Result<MotionCurve> curve = backbone_curve(system, {0, {}, 3.0}, options);
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  std::vector<CurvePoint> joints;
  for (const Bifurcation& found : curve->bifurcations)
    if (found.kind == BifurcationKind::kBranch &&
        odd_harmonics(found.point.motion).norm() < 1e-9 * found.point.motion.norm())
      joints.push_back(found.point);
  ASSERT_EQ(joints.size(), 2U);
  const auto trace = [&](const CurvePoint& point) {
    return trace_of_variation(w2, c,
                              std::abs((point.motion * fourier_row(point.harmonics(), 0.0))[1]),
                              std::numbers::pi / point.omega);
  };
  // Both edges of the instability have a double multiplier at -1. The first is interpolated within
  // a step; the second is found to 1e-5 of the unit circle, of which the trace has the square.
  EXPECT_NEAR(trace(joints[0]), -2.0, 1e-3);
  EXPECT_NEAR(trace(joints[1]), -2.0, 1e-7);
  // Before and beyond, mode 2 follows in opposite phase: the sign of Re(z_1^2 / z_2) with the
  // complex amplitudes z_k of mode 1 in harmonic 1 and of mode 2 in harmonic 2.
  const auto sign = [](const CurvePoint& point) {
    const std::complex<double> one(point.motion(0, 1), -point.motion(0, 2));
    const std::complex<double> two(point.motion(1, 3), -point.motion(1, 4));
    return (one * one * std::conj(two)).real() > 0.0;
  };
  EXPECT_NE(sign(curve->points[5]), sign(curve->points.back()));
  EXPECT_NEAR(curve->points.back().amplitude, 3.0, 1e-9);
}

}  // namespace
}  // namespace tremolo
