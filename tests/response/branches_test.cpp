// Damped backbones, curves of folds and branches against closed forms.
#include "runtime/response/branches.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/response/backbone.h"
#include "runtime/response/equations/harmonic_balance.h"
#include "tests/response/oscillators.h"

namespace tremolo {
namespace {

TEST(DampedBackbone, ItsForceGivesTheWorkThatDampingTakes) {
  const Duffing duffing{1.0, 1.0, 0.02};
  const VibratingSystem system = system_of(duffing);
  const Eigen::VectorXd load = Eigen::VectorXd::Constant(1, 0.5);
  const Result<MotionCurve> curve =
      damped_backbone_curve(system, {0, {}, load, 1.5}, plain_options(13));
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  for (const CurvePoint& point : curve->points) {
    // Over a period: pi F b_1 of the force F cos; pi c omega sum k^2 (a_k^2 + b_k^2) of damping.
    double taken = 0.0;
    for (int k = 1; k <= 13; ++k)
      taken += k * k * point.motion.middleCols(2 * k - 1, 2).squaredNorm();
    taken *= 0.04 * point.omega;
    EXPECT_NEAR(0.5 * point.load * point.motion(0, 2), taken, 1e-8 * taken);
    // In quadrature to the corrector's tolerance.
    EXPECT_NEAR(point.motion(0, 1), 0.0, 1e-9 * point.motion(0, 2));
  }
}

TEST(DampedBackbone, ItApproachesTheUndampedOneByTheSquareOfDamping) {
  double before = 0.0;
  for (const double zeta : {0.08, 0.04, 0.02}) {
    const VibratingSystem system = system_of({1.0, 1.0, zeta});
    const CurveOptions options = plain_options(13);
    const Eigen::VectorXd load = Eigen::VectorXd::Ones(1);
    const Result<MotionCurve> damped = damped_backbone_curve(system, {0, {}, load, 1.0}, options);
    const Result<MotionCurve> free = backbone_curve(system, {0, {}, 1.0}, options);
    ASSERT_TRUE(damped && free);
    const double distance =
        std::abs(damped->points.back().omega - free->points.back().omega) / zeta;
    EXPECT_LT(distance, zeta);  // so that the relative distance is below zeta^2
    if (before > 0.0) {
      EXPECT_LT(distance, 0.6 * before);
    }
    before = distance;
  }
}

TEST(DampedBackbone, ItIsTheRidgeOfTheResponseCurves) {
  const double zeta = 0.02;
  const VibratingSystem system = system_of({1.0, 1.0, zeta});
  const CurveOptions options = plain_options(9);
  const Eigen::VectorXd load = Eigen::VectorXd::Ones(1);
  const Result<MotionCurve> ridge = damped_backbone_curve(system, {0, {}, load, 1.0}, options);
  ASSERT_TRUE(ridge);
  for (const std::size_t i : {ridge->points.size() / 2, ridge->points.size() - 1}) {
    const CurvePoint& point = ridge->points[i];
    const FourierSeries force = cosine_force(point.load * load);
    const Result<MotionCurve> curve = response_curve(system, {force, 0.7, 2.5}, options);
    ASSERT_TRUE(curve);
    const auto peak =
        std::max_element(curve->points.begin(), curve->points.end(),
                         [](const auto& a, const auto& b) { return a.amplitude < b.amplitude; });
    // The largest amplitude and quadrature differ by the square of zeta; the peak lies between two
    // points, half a step of 0.1 from the nearest: 1 - cos of that angle.
    EXPECT_NEAR(peak->amplitude, point.amplitude, 2e-3 * point.amplitude);
  }
}

// The folds of the Duffing oscillator with one harmonic: with u = A^2 and s = w0^2 - w^2,
// F^2 = u ((s + 3/4 gamma u)^2 + (c w)^2) is stationary in u.
TEST(FoldCurve, OfOneHarmonicIsTheClosedForm) {
  const double gamma = 1.0, c = 0.04, f = 0.1;
  const VibratingSystem system = system_of({1.0, gamma, 0.02});
  const CurveOptions options = plain_options(1);
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, f));
  const ResponseRequest request{force, 0.6, 2.5};
  const Result<MotionCurve> response = response_curve(system, request, options);
  ASSERT_TRUE(response);
  ASSERT_FALSE(response->bifurcations.empty());
  // Towards smaller loads the first fold passes the cusp and returns on the second one's side.
  CurveOptions down = options;
  down.most_points = 400;
  const CurvePoint& fold = response->bifurcations.front().point;
  ASSERT_EQ(response->bifurcations.front().kind, BifurcationKind::kFold);
  double least = 1.0;
  for (const double to_load : {2.0, 1e-3}) {
    const Result<MotionCurve> curve = fold_curve(system, request, fold, to_load, down);
    ASSERT_TRUE(curve) << curve.error().message;
    EXPECT_GT(curve->points.size(), 5U);
    if (to_load > 1.0) {
      EXPECT_EQ(curve->end, CurveEnd::kDone);
      EXPECT_NEAR(curve->points.back().load, to_load, 1e-9);
    }
    for (const CurvePoint& point : curve->points) {
      const double u = point.motion.rightCols(2).squaredNorm(), w = point.omega;
      const double s = 1.0 - w * w, drop = c * w;
      const double stationary = (s + 0.75 * gamma * u) * (s + 2.25 * gamma * u) + drop * drop;
      // Relative to its largest part; the corrector stops at 1e-10.
      EXPECT_NEAR(stationary, 0.0, 1e-8 * (s * s + u * u + drop * drop)) << w;
      const double square = u * (std::pow(s + 0.75 * gamma * u, 2) + drop * drop);
      EXPECT_NEAR(f * point.load, std::sqrt(square), 1e-8 * f) << w;
      least = std::min(least, point.load);
    }
  }
  // The cusp: s = -sqrt(3) c w, u = -8 s / (9 gamma), F^2 = 4/3 u (c w)^2.
  const double w = 0.5 * (std::sqrt(3.0) * c + std::sqrt(3.0 * c * c + 4.0));
  const double u = 8.0 * std::sqrt(3.0) * c * w / (9.0 * gamma);
  const double cusp = std::sqrt(4.0 / 3.0 * u) * c * w / f;
  EXPECT_GE(least, cusp * (1.0 - 1e-9));
  EXPECT_LT(least, 1.02 * cusp);  // points on both sides, a step apart
}

// The monodromy of x'' + d x' + (k + 2 g A^2 cos^2 w t) x = 0 by Runge-Kutta steps.
Eigen::Matrix2d mathieu_monodromy(double k, double d, double g, double A, double w) {
  const auto slope = [&](double t, const Eigen::Matrix2d& y) {
    const double c = std::cos(w * t);
    Eigen::Matrix2d out;
    out.row(0) = y.row(1);
    out.row(1) = -d * y.row(1) - (k + 2.0 * g * A * A * c * c) * y.row(0);
    return out;
  };
  Eigen::Matrix2d y = Eigen::Matrix2d::Identity();
  const int steps = 2000;
  const double h = 2.0 * std::numbers::pi / w / steps;
  for (int n = 0; n < steps; ++n) {
    const double t = n * h;
    const Eigen::Matrix2d k1 = slope(t, y), k2 = slope(t + 0.5 * h, y + 0.5 * h * k1);
    const Eigen::Matrix2d k3 = slope(t + 0.5 * h, y + 0.5 * h * k2), k4 = slope(t + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y;
}

// q1 is linear and forced, V has g q1^2 q2^2: near 1:1 the motion of q1 makes q2 unstable.
TEST(CrossingBranch, BreaksTheSymmetryBetweenTwoBranchPoints) {
  const double g = 0.2, d = 0.02, f = 0.1;
  const std::vector<double> cubic(4, 0.0), quartic{0.0, 0.0, g / 6.0, 0.0, 0.02};
  const VibratingSystem system{*Potential::create(Eigen::Vector2d(1.0, 0.8), cubic, quartic),
                               Eigen::Vector2d(0.1, d),
                               0.0,
                               {}};
  const CurveOptions options = plain_options(7);
  const ResponseRequest request{cosine_force(Eigen::Vector2d(f, 0.0)), 0.7, 1.4};
  const Result<MotionCurve> curve = response_curve(system, request, options);
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  std::vector<const CurvePoint*> branches;
  for (const Bifurcation& found : curve->bifurcations) {
    ASSERT_EQ(found.kind, BifurcationKind::kBranch);
    branches.push_back(&found.point);
    const CurvePoint& point = found.point;
    const double A = f / std::hypot(1.0 - point.omega * point.omega, 0.1 * point.omega);
    const Eigen::Matrix2d M = mathieu_monodromy(0.8, d, g, A, point.omega);
    // A multiplier at +1: the determinant is zero.
    EXPECT_NEAR((M - Eigen::Matrix2d::Identity()).determinant(), 0.0, 1e-6) << point.omega;
  }
  ASSERT_EQ(branches.size(), 2U);
  for (const int sign : {1, -1}) {
    const Result<MotionCurve> branch =
        crossing_branch(system, request, *curve, *branches[0], sign, options);
    ASSERT_TRUE(branch) << branch.error().message;
    ASSERT_EQ(branch->end, CurveEnd::kDone);
    double most = 0.0;
    for (const CurvePoint& point : branch->points) {
      HarmonicBalance balance(system, point.harmonics());
      FourierSeries residual;
      balance.residual(point.motion, point.omega, 0.0,
                       with_harmonics(request.force, point.harmonics()), residual);
      EXPECT_LE(residual.norm(), 1e-9);
      most = std::max(most, point.motion.row(1).norm());
    }
    EXPECT_GT(most, 0.1);
    // It meets the curve again at the other branch point; its last point is within half a step.
    EXPECT_LT(branch->points.back().motion.row(1).norm(), 0.2 * most);
    EXPECT_NEAR(branch->points.back().omega, branches[1]->omega, 0.002);
  }
}

// A millionth of the load on the second coordinate leaves a narrow gap where the branches crossed.
// The step that crosses it says so, and where: at the branch points without that part of the load,
// however long it is.
TEST(CrossingBranch, AGapIsAnImperfectBranchPointAtItsOwnFrequency) {
  const double g = 0.2, d = 0.02, f = 0.1;
  const std::vector<double> cubic(4, 0.0), quartic{0.0, 0.0, g / 6.0, 0.0, 0.02};
  const VibratingSystem system{*Potential::create(Eigen::Vector2d(1.0, 0.8), cubic, quartic),
                               Eigen::Vector2d(0.1, d),
                               0.0,
                               {}};
  const auto branches_of = [&](double part, double step) {
    CurveOptions options = plain_options(7);
    options.longest_step = step;
    const Result<MotionCurve> curve =
        response_curve(system, {cosine_force(Eigen::Vector2d(f, part * f)), 0.7, 1.4}, options);
    EXPECT_TRUE(curve && curve->end == CurveEnd::kDone);
    std::vector<Bifurcation> found;
    for (const Bifurcation& at : curve->bifurcations)
      if (at.kind == BifurcationKind::kBranch) found.push_back(at);
    return found;
  };
  const std::vector<Bifurcation> exact = branches_of(0.0, 0.1);
  ASSERT_EQ(exact.size(), 2U);
  for (const Bifurcation& at : exact) EXPECT_FALSE(at.imperfect);
  for (const double step : {0.1, 0.07, 0.03}) {
    const std::vector<Bifurcation> gaps = branches_of(1e-6, step);
    ASSERT_EQ(gaps.size(), 2U) << step;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(gaps[i].imperfect);
      // The gap is as wide as the part of the load to the power 2/3: 1e-4.
      EXPECT_NEAR(gaps[i].point.omega, exact[i].point.omega, 2e-3) << step;
    }
  }
}

// Two modes whose frequencies are 0.3 % apart, of which a little of the load excites the second:
// parts of the curve are near each other. A step must not end on another part, from which the curve
// would be followed back; the peak is that of steps a fifth as long.
TEST(CrossingBranch, StepsStayOnTheirPartOfTheCurve) {
  const double g = 0.5, d = 1.0027916379560122, f = 0.011372723575490922;
  const std::vector<double> cubic(4, 0.0),
      quartic{g / 4.0, 0.0, g / 12.0 * 1.3962374072512826, 0.0, g / 4.0};
  const double zeta = 0.0070140003239913314;
  const VibratingSystem system{*Potential::create(Eigen::Vector2d(1.0, d * d), cubic, quartic),
                               Eigen::Vector2d(2.0 * zeta, 2.0 * zeta * d),
                               0.0,
                               {}};
  const ResponseRequest request{cosine_force(Eigen::Vector2d(f, 0.0021124536107026415 * f)), 0.5,
                                2.3417037793359947};
  std::vector<double> peaks;
  for (const double step : {0.1, 0.02}) {
    CurveOptions options = plain_options(3);
    options.stability = false;
    options.longest_step = step;
    const Result<MotionCurve> curve = response_curve(system, request, options);
    ASSERT_TRUE(curve) << curve.error().message;
    EXPECT_EQ(curve->end, CurveEnd::kDone);
    double peak = 0.0;
    for (std::size_t i = 1; i < curve->points.size(); ++i) {
      const CurvePoint &a = curve->points[i - 1], &b = curve->points[i];
      const double size = std::max(curve->points[0].motion.norm(), a.motion.norm());
      EXPECT_LE((b.motion - a.motion).norm() / size, 2.0 * step) << a.omega;
      peak = std::max(peak, b.amplitude);
    }
    peaks.push_back(peak);
  }
  EXPECT_NEAR(peaks[0], peaks[1], 1e-3 * peaks[1]);
}

}  // namespace
}  // namespace tremolo
