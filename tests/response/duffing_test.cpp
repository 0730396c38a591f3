// One coordinate: Duffing's oscillator, whose backbone has a closed form.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/response/backbone.h"
#include "runtime/response/response.h"
#include "tests/response/oscillators.h"

namespace tremolo {
namespace {

// K(m) by the arithmetic-geometric mean.
double elliptic_integral(double m) {
  double a = 1.0, b = std::sqrt(1.0 - m);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi / (2.0 * a);
}

double exact_frequency(const Duffing& d, double amplitude) {
  const double stiff = d.omega * d.omega + d.gamma * amplitude * amplitude;
  const double m = d.gamma * amplitude * amplitude / (2.0 * stiff);
  return 2.0 * std::numbers::pi * std::sqrt(stiff) / (4.0 * elliptic_integral(m));
}

TEST(Duffing, ItsBackboneIsThatOfTheEllipticIntegral) {
  for (const double gamma : {1.0, -0.2}) {
    const Duffing duffing{2.0, gamma, 0.0};
    const VibratingSystem system = system_of(duffing);
    CurveOptions options = plain_options(25);
    const Result<MotionCurve> curve = backbone_curve(system, {0, {}, 3.0}, options);
    ASSERT_TRUE(curve) << curve.error().message;
    ASSERT_EQ(curve->end, CurveEnd::kDone);
    EXPECT_GT(curve->points.size(), 20U);
    for (const CurvePoint& point : curve->points) {
      const double exact = exact_frequency(duffing, point.amplitude);
      EXPECT_NEAR(point.omega, exact, 1e-8 * exact) << point.amplitude;
      EXPECT_TRUE(point.stable);
      const double energy =
          0.5 * 4.0 * std::pow(point.amplitude, 2) + 0.25 * gamma * std::pow(point.amplitude, 4);
      EXPECT_NEAR(mean_energy(system, point.motion, point.omega), energy, 1e-8 * energy);
    }
    EXPECT_NEAR(curve->points.back().amplitude, 3.0, 1e-9);
  }
}

// Periodic, and a multiplier at +1: three equations for the start and the frequency.
Eigen::Vector3d fold_equations(const Duffing& d, double f, const Eigen::Vector3d& at) {
  const Shot shot = shoot(d, f, at[2], at.head<2>());
  Eigen::Vector3d out;
  out.head<2>() = shot.end - at.head<2>();
  out[2] = (shot.monodromy - Eigen::Matrix2d::Identity()).determinant();
  return out;
}

TEST(Duffing, ItsFoldsAreThoseOfShooting) {
  const Duffing duffing{1.0, 1.0, 0.02};
  const double f = 0.1;
  const VibratingSystem system = system_of(duffing);
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, f));
  const Result<MotionCurve> curve = response_curve(system, {force, 0.6, 2.5}, plain_options(21));
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  std::vector<double> folds;
  for (const Bifurcation& found : curve->bifurcations) {
    EXPECT_EQ(found.kind, BifurcationKind::kFold);
    const CurvePoint& point = found.point;
    Eigen::Vector3d at;
    at << point.motion * fourier_row(21, 0.0),
        point.omega * point.motion * fourier_slope_row(21, 0.0), point.omega;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d value = fold_equations(duffing, f, at);
      Eigen::Matrix3d slope;
      for (int j = 0; j < 3; ++j) {
        const Eigen::Vector3d e = 1e-6 * Eigen::Vector3d::Unit(j);
        slope.col(j) =
            (fold_equations(duffing, f, at + e) - fold_equations(duffing, f, at - e)) / 2e-6;
      }
      at -= slope.partialPivLu().solve(value);
    }
    folds.push_back(point.omega);
    // 4000 Runge-Kutta steps a period err by 1e-11; 21 harmonics by 1e-12.
    EXPECT_NEAR(point.omega, at[2], 1e-8 * at[2]);
  }
  ASSERT_EQ(folds.size(), 2U);
  EXPECT_GT(folds[0], folds[1]);
}

TEST(Duffing, IsUnstableBetweenItsFoldsAndStableOutside) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.02});
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 0.1));
  const Result<MotionCurve> curve = response_curve(system, {force, 0.6, 2.5}, plain_options(9));
  ASSERT_TRUE(curve);
  double before = 0.0;
  int changes = 0;
  for (std::size_t i = 1; i < curve->points.size(); ++i) {
    const CurvePoint &a = curve->points[i - 1], &b = curve->points[i];
    if (a.stable != b.stable) ++changes;
    const bool back = b.omega < a.omega && a.omega < before;
    if (back) {
      EXPECT_FALSE(a.stable) << a.omega;
    }
    before = a.omega;
  }
  EXPECT_EQ(changes, 2);
}

// With few harmonics the multipliers, which are those of the whole linear equation, pass +1 beside
// the points at which the equations turn. det(I - M) is negative where one real multiplier is above
// 1: the curve of one oscillator under a sine is unstable between its folds and nowhere else.
TEST(Duffing, FewHarmonicsHaveNoEventButTheirFolds) {
  for (const double f : {0.1, 0.4})
    for (const Eigen::Index harmonics : {1, 2, 3, 5}) {
      const VibratingSystem system = system_of({1.0, 1.0, 0.02});
      const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, f));
      const Result<MotionCurve> curve =
          response_curve(system, {force, 0.8, 4.0}, plain_options(harmonics));
      ASSERT_TRUE(curve);
      ASSERT_EQ(curve->end, CurveEnd::kDone);
      ASSERT_EQ(curve->bifurcations.size(), 2U) << f << " " << harmonics;
      for (const Bifurcation& found : curve->bifurcations)
        EXPECT_EQ(found.kind, BifurcationKind::kFold) << f << " " << harmonics;
      const double first = curve->bifurcations[0].point.omega;
      const double last = curve->bifurcations[1].point.omega;
      // Between the folds the frequency falls.
      const std::vector<CurvePoint>& points = curve->points;
      for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const bool falls = points[i + 1].omega < points[i - 1].omega;
        const bool turns =
            (points[i + 1].omega < points[i].omega) != (points[i].omega < points[i - 1].omega);
        if (turns) continue;
        EXPECT_EQ(points[i].stable, !falls)
            << f << " " << harmonics << ": " << points[i].omega << " of " << last << " " << first;
      }
    }
}

TEST(Duffing, ItsMultipliersAreThoseOfShooting) {
  const Duffing duffing{1.0, 1.0, 0.02};
  const VibratingSystem system = system_of(duffing);
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 0.1));
  const Result<MotionCurve> curve = response_curve(system, {force, 0.6, 2.5}, plain_options(15));
  ASSERT_TRUE(curve);
  for (std::size_t i = 0; i < curve->points.size(); i += 10) {
    const CurvePoint& point = curve->points[i];
    Eigen::Vector2d start;
    start << point.motion * fourier_row(15, 0.0),
        point.omega * point.motion * fourier_slope_row(15, 0.0);
    const Shot shot = shoot(duffing, 0.1, point.omega, start);
    EXPECT_LE((shot.end - start).norm(), 1e-8 * start.norm());
    Eigen::VectorXcd exact = shot.monodromy.eigenvalues();
    for (const auto& multiplier : point.multipliers)
      // Order six with a tenth of a radian a step; a double multiplier takes the root of an error.
      EXPECT_LE(std::min(std::abs(multiplier - exact[0]), std::abs(multiplier - exact[1])), 1e-6)
          << point.omega;
  }
}

TEST(Duffing, HalfTheStepsAreTakenFarFromTheUnitCircleAlone) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.02});
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 0.1));
  const Result<MotionCurve> curve = response_curve(system, {force, 0.6, 2.5}, plain_options(9));
  ASSERT_TRUE(curve);
  Floquet floquet(system);
  int with_half = 0;
  for (const CurvePoint& point : curve->points) {
    const auto largest = [&](int steps) {
      return floquet.multipliers(point.motion, point.omega, steps)[0];
    };
    const int steps = floquet_steps(point.harmonics());
    const bool half = point.multipliers[0] == largest(steps / 2);
    EXPECT_TRUE(half || point.multipliers[0] == largest(steps)) << point.omega;
    // A fold is at 1; the linear oscillator decays by exp(-2 pi zeta / omega) in a period.
    const double decay = 2.0 * std::numbers::pi * 0.02 / point.omega;
    EXPECT_FALSE(half && std::abs(point.multipliers[0]) > std::exp(-0.25 * decay)) << point.omega;
    // 512 steps: an error of 1e-12.
    EXPECT_EQ(point.stable, std::abs(largest(512)) < 1.0) << point.omega;
    with_half += half ? 1 : 0;
  }
  EXPECT_GT(with_half, static_cast<int>(curve->points.size()) / 3);
}

TEST(Duffing, HarmonicsGrowWhereTheLastHoldTooMuch) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.02});
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 2.0));
  CurveOptions options = plain_options(3);
  options.most_harmonics = 31;
  options.harmonic_share = 1e-6;
  const Result<MotionCurve> curve = response_curve(system, {force, 0.6, 4.0}, options);
  ASSERT_TRUE(curve);
  EXPECT_LE(curve->largest_share, 1e-6);
  Eigen::Index most = 0;
  for (const CurvePoint& point : curve->points) most = std::max(most, point.harmonics());
  EXPECT_GT(most, 7);
  EXPECT_LT(most, 31);
  // Above resonance the motion is nearly linear again.
  EXPECT_LT(curve->points.back().harmonics(), most);
  for (const CurvePoint& point : curve->points) EXPECT_EQ(point.share, last_share(point.motion));
}

TEST(Duffing, HarmonicsThatGrowAtTheFirstPointLeaveItsFrequency) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.02});
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 2.0));
  CurveOptions options = plain_options(3);
  options.most_harmonics = 31;
  int grown = 0;
  for (const double share : {1e-3, 1e-4, 1e-6})
    for (const double from : {0.5, 0.55, 0.6, 0.65, 0.7, 0.8, 0.9, 1.0})
      for (const double to : {0.3, 4.0}) {
        options.harmonic_share = share;
        const Result<MotionCurve> curve = response_curve(system, {force, from, to}, options);
        ASSERT_TRUE(curve);
        EXPECT_EQ(curve->points.front().omega, from) << share << " " << to;
        EXPECT_GT(curve->points.size(), 5U) << share << " " << from << " " << to;
        EXPECT_LE(curve->points.front().share, share);
        EXPECT_EQ(curve->refused, 0);
        grown += curve->points.front().harmonics() > 3 ? 1 : 0;
      }
  EXPECT_GT(grown, 20);
}

TEST(Duffing, TheHarmonicsLeftOutAreEstimated) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.0});
  CurveOptions few = plain_options(3), many = plain_options(15);
  for (const double amplitude : {0.3, 1.0}) {
    const Result<MotionCurve> a = backbone_curve(system, {0, {}, amplitude}, few);
    const Result<MotionCurve> b = backbone_curve(system, {0, {}, amplitude}, many);
    ASSERT_TRUE(a && b);
    const FourierSeries& motion = b->points.back().motion;
    const double left_out = motion.rightCols(2 * 12).norm() / motion.rightCols(2 * 15).norm();
    // The linear response leaves the stiffening by the motion itself out: 3/2 A^2 relative to
    // 25 omega^2 - 1.
    EXPECT_NEAR(a->points.back().missing, left_out, 0.1 * left_out);
  }
}

// Small vibration about a large sag x: w^2 = w0^2 + 3 gamma x^2 and, with the damping c, the
// largest amplitude f / (c sqrt(w^2 - c^2/4)) at sqrt(w^2 - c^2/2). The constant part must not
// lengthen the steps.
TEST(Duffing, UnderAConstantForceIsFollowedThroughTheResonanceAboutItsSag) {
  const Duffing duffing{1.0, 1.0, 0.01};
  constexpr double kSag = 2.0, kForce = 1e-5;
  const double square = 1.0 + 3.0 * kSag * kSag, damping = 2.0 * duffing.zeta;
  const double resonance = std::sqrt(square - 0.5 * damping * damping);
  const double largest = kForce / (damping * std::sqrt(square - 0.25 * damping * damping));
  FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, kForce));
  force(0, 0) = kSag + kSag * kSag * kSag;
  for (const double to : {3.7, 4.0, 5.0, 7.3}) {
    SCOPED_TRACE(to);
    const Result<MotionCurve> curve =
        response_curve(system_of(duffing), {force, 1.0, to}, plain_options(3));
    ASSERT_TRUE(curve) << curve.error().message;
    ASSERT_EQ(curve->end, CurveEnd::kDone);
    const auto vibration = [](const CurvePoint& point) {
      return point.motion.middleCols(1, 2).norm();
    };
    const auto peak =
        std::max_element(curve->points.begin(), curve->points.end(),
                         [&](const auto& a, const auto& b) { return vibration(a) < vibration(b); });
    EXPECT_NEAR(peak->omega, resonance, 1e-3 * resonance);
    EXPECT_NEAR(vibration(*peak), largest, 0.02 * largest);
  }
}

// The motion at rest that is pushed by the whole force: what a body does that is stepped.
double settled_amplitude(const Duffing& duffing, double f, double omega) {
  Eigen::Vector2d state = Eigen::Vector2d::Zero();
  for (int period = 0; period < 600; ++period) state = shoot(duffing, f, omega, state, 200).end;
  double largest = 0.0;
  // A fraction of the period after the other: an omega of n times the frequency ends 1/n of it.
  for (int part = 1; part <= 64; ++part) {
    const double angle = 2.0 * std::numbers::pi * part / 64.0;
    Eigen::Vector2d at = state;
    double t = 0.0;
    const double h = angle / omega / 200.0;
    const auto slope = [&](double time, const Eigen::Vector2d& y) {
      return Eigen::Vector2d(
          y[1], -2.0 * duffing.zeta * duffing.omega * y[1] - duffing.omega * duffing.omega * y[0] -
                    duffing.gamma * std::pow(y[0], 3) + f * std::cos(omega * time));
    };
    for (int n = 0; n < 200; ++n, t += h) {
      const Eigen::Vector2d k1 = slope(t, at), k2 = slope(t + 0.5 * h, at + 0.5 * h * k1);
      const Eigen::Vector2d k3 = slope(t + 0.5 * h, at + 0.5 * h * k2),
                            k4 = slope(t + h, at + h * k3);
      at += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    largest = std::max(largest, std::abs(at[0]));
  }
  return largest;
}

// Just above a resonance the motion over the load turns back, so that the load cannot simply grow.
// Where there is one motion alone, below the fold at which the curve from below jumps up, the
// stepped body settles on it.
TEST(Duffing, ACurveBeginsAtAndAboveItsResonance) {
  for (const auto& [zeta, f] : {std::pair(0.02, 0.3), {0.01, 0.3}, {0.02, 1.0}}) {
    const Duffing duffing{1.0, 1.0, zeta};
    const VibratingSystem system = system_of(duffing);
    const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, f));
    for (const double from : {0.9, 1.0, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3})
      for (const double to : {0.5, 4.0}) {
        CurveOptions options = plain_options(7);
        options.most_harmonics = 15;
        const Result<MotionCurve> curve = response_curve(system, {force, from, to}, options);
        ASSERT_TRUE(curve) << zeta << " " << f << " " << from << ": " << curve.error().message;
        EXPECT_EQ(curve->end, CurveEnd::kDone) << zeta << " " << f << " " << from << " " << to;
        const double settled = settled_amplitude(duffing, f, from);
        EXPECT_NEAR(curve->points.front().amplitude, settled, 2e-3 * settled)
            << zeta << " " << f << " " << from;
      }
  }
}

}  // namespace
}  // namespace tremolo
