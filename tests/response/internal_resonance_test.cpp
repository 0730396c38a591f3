// Two oscillators near 1:3, V = q1^2/2 + w2^2 q2^2/2 + q1^4/4 + k q1^3 q2 + g q1^2 q2^2: mode 1
// hardens until three times its frequency meets that of mode 2.
#include <cmath>
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

}  // namespace
}  // namespace tremolo
