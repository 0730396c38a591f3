// Models of several coordinates, against closed forms and against stepping in time.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/body.h"
#include "runtime/model.h"
#include "runtime/response/backbone.h"
#include "runtime/response/equations/harmonic_balance.h"
#include "runtime/response/response.h"
#include "runtime/response/static_state.h"
#include "tests/response/oscillators.h"
#include "tests/support/linear_model.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using testing::random_strain_model;
using testing::sample_basis;
using testing::spread_omega;
using testing::StrainModel;

// A model with strains in closed form, and its system with stiffness damping.
struct Sample {
  StrainModel strains;
  Model::Pointer model;
  VibratingSystem system;
};

Sample sample(const Eigen::VectorXd& omega, double nonlinearity, double alpha, double beta,
              unsigned seed = 3) {
  StrainModel strains = random_strain_model(omega, nonlinearity, seed);
  Model::Pointer model = *Model::from_data(sample_basis(strains));
  VibratingSystem system = *vibrating_system(*model, alpha, beta);
  return {std::move(strains), std::move(model), std::move(system)};
}

FourierSeries random_series(Eigen::Index r, Eigen::Index harmonics, double scale) {
  return testing::random_vector(r * (2 * harmonics + 1), scale, 11).reshaped(r, 2 * harmonics + 1);
}

TEST(HarmonicBalance, ItsForceIsExactWithTheFewestSamples) {
  const double beta = 0.03, alpha = 0.2, omega = 1.3;
  const Sample s = sample(spread_omega(3, 1.0, 4.0), 0.5, alpha, beta);
  for (const Eigen::Index H : {1, 2, 5}) {
    const FourierSeries motion = random_series(3, H, 0.5);
    HarmonicBalance balance(s.system, H);
    FourierSeries residual;
    balance.residual(motion, omega, 0.0, FourierSeries::Zero(3, 2 * H + 1), residual);
    // The same by the strains' closed form, projected with far more samples than harmonics.
    FourierSeries expected = FourierSeries::Zero(3, 2 * H + 1);
    constexpr int kSamples = 200;
    for (int n = 0; n < kSamples; ++n) {
      const double theta = 2.0 * std::numbers::pi * n / kSamples;
      const Eigen::VectorXd row = fourier_row(H, theta), slope = fourier_slope_row(H, theta);
      const Eigen::VectorXd q = motion * row, v = omega * motion * slope;
      Eigen::VectorXd bend(2 * H + 1);
      bend.setZero();
      for (Eigen::Index k = 1; k <= H; ++k)
        bend.segment(2 * k - 1, 2) = -static_cast<double>(k * k) * row.segment(2 * k - 1, 2);
      const Eigen::VectorXd force = testing::strain_force(s.strains, q) +
                                    beta * testing::strain_damping_force(s.strains, q, v) +
                                    alpha * v + omega * omega * motion * bend;
      expected += force * row.transpose() * (2.0 / kSamples);
    }
    expected.col(0) *= 0.5;
    EXPECT_LE((residual - expected).norm(), 1e-13 * expected.norm()) << H;
  }
}

TEST(HarmonicBalance, ItsJacobianIsTheDerivativeOfItsResidual) {
  const Sample s = sample(spread_omega(3, 1.0, 4.0), 0.5, 0.2, 0.03);
  const Eigen::Index H = 3;
  HarmonicBalance balance(s.system, H);
  const FourierSeries motion = random_series(3, H, 0.5), none = FourierSeries::Zero(3, 7);
  const Eigen::Index n = balance.unknowns();
  Eigen::MatrixXd jacobian(n, n);
  Eigen::VectorXd by_omega(n), by_xi;
  balance.jacobian(motion, 1.3, 0.1, jacobian, by_omega, &by_xi);
  // The residual is cubic in each unknown: central differences err by e^2 of the third derivative.
  const double e = 1e-4;
  const auto difference = [&](const FourierSeries& direction, double d_omega, double d_xi) {
    FourierSeries ahead, behind;
    balance.residual(motion + e * direction, 1.3 + e * d_omega, 0.1 + e * d_xi, none, ahead);
    balance.residual(motion - e * direction, 1.3 - e * d_omega, 0.1 - e * d_xi, none, behind);
    return Eigen::VectorXd(((ahead - behind) / (2.0 * e)).reshaped());
  };
  const double scale = jacobian.cwiseAbs().maxCoeff();
  for (Eigen::Index j = 0; j < n; ++j) {
    FourierSeries direction = none;
    direction.reshaped()[j] = 1.0;
    EXPECT_LE((difference(direction, 0.0, 0.0) - jacobian.col(j)).norm(), 1e-6 * scale) << j;
  }
  EXPECT_LE((difference(none, 1.0, 0.0) - by_omega).norm(), 1e-6 * scale);
  EXPECT_LE((difference(none, 0.0, 1.0) - by_xi).norm(), 1e-6 * scale);
}

TEST(Response, OfALinearModelIsItsTransferFunction) {
  const Model::Pointer model = testing::linear_model(spread_omega(4, 1.0, 9.0));
  DampingRatios ratios;
  ratios.of_modes = {0.02, 0.01, 0.05};
  const VibratingSystem system =
      *vibrating_system(*model, 0.0, 0.0, modal_rates(ratios, model->lambda()));
  FourierSeries force = FourierSeries::Zero(4, 5);
  force.col(0) = Eigen::VectorXd::Constant(4, 0.3);
  force.col(1) = testing::random_vector(4, 1.0, 1);
  force.col(2) = testing::random_vector(4, 1.0, 2);
  force.col(4) = testing::random_vector(4, 1.0, 3);
  for (const bool upwards : {true, false}) {
    const ResponseRequest request{force, upwards ? 0.5 : 10.0, upwards ? 10.0 : 0.5};
    const Result<MotionCurve> curve = response_curve(system, request, plain_options(3));
    ASSERT_TRUE(curve) << curve.error().message;
    ASSERT_EQ(curve->end, CurveEnd::kDone);
    EXPECT_TRUE(curve->bifurcations.empty());
    // The ratio 2 zeta omega is the requested one also for the last mode, which repeats the third.
    EXPECT_NEAR(system.damping[3], 2.0 * 0.05 * 9.0, 1e-14);
    for (const CurvePoint& point : curve->points) {
      EXPECT_TRUE(point.stable);
      FourierSeries exact = FourierSeries::Zero(4, 7);
      exact.col(0) = force.col(0).cwiseQuotient(model->lambda());
      for (int k = 1; k <= 2; ++k)
        for (Eigen::Index i = 0; i < 4; ++i) {
          const double speed = k * point.omega;
          const std::complex<double> f(force(i, 2 * k - 1), -force(i, 2 * k));
          const std::complex<double> u =
              f /
              std::complex<double>(model->lambda()[i] - speed * speed, speed * system.damping[i]);
          exact(i, 2 * k - 1) = u.real();
          exact(i, 2 * k) = -u.imag();
        }
      // The matrix's condition is some hundred.
      EXPECT_LE((point.motion - exact).norm(), 1e-12 * exact.norm()) << point.omega;
    }
    // The last point is sought until it is within 1e-11 of the end.
    EXPECT_NEAR(curve->points.back().omega, request.omega_to, 2e-11 * request.omega_to);
  }
}

// The state of a motion at t = 0.
State state_of(const CurvePoint& point) {
  State state;
  const Eigen::Index H = point.harmonics();
  state.q = point.motion * fourier_row(H, 0.0);
  state.p = point.omega * point.motion * fourier_slope_row(H, 0.0);
  return state;
}

// The relative distance from the motion after so many periods of stepping with ep4. displaced: the
// relative distance at the start.
double distance_after(const Sample& s, const CurvePoint& point, double load, double alpha,
                      double beta, double displaced, int periods, int steps) {
  const double period = 2.0 * std::numbers::pi / point.omega;
  IntegratorOptions options;
  options.step = period / steps;
  options.alpha = alpha;
  options.beta = beta;
  options.tolerance = 1e-12;
  Body body = std::move(*Body::create(s.model, "ep4", options));
  if (load != 0.0) {
    const Signal sine{.kind = SignalKind::kSine, .frequency = 1.0 / period};
    EXPECT_TRUE(body.add_load(sine, 3, {0.0, 0.0, load}));
  }
  const State start = state_of(point);
  EXPECT_TRUE(body.set_state((1.0 + displaced) * start.q, start.p));
  for (int n = 0; n < periods * steps; ++n) EXPECT_TRUE(body.step().converged);
  const double size = std::hypot(start.q.norm(), start.p.norm() / point.omega);
  return std::hypot((body.state().q - start.q).norm(),
                    (body.state().p - start.p).norm() / point.omega) /
         size;
}

TEST(Response, SteppingInTimeStaysOnBothStableBranchesAndLeavesTheUnstableOne) {
  // The strain q + 0.3 q^2 of coordinate 1 softens it by 3 (0.3 A)^2: at A = 0.6 by 0.1, five times
  // the damping ratio.
  const double alpha = 0.02, beta = 0.02;
  StrainModel strains{Eigen::Vector2d(1.0, 4.0),
                      {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()}};
  strains.b[0] << 0.3, 0.1, 0.1, 0.05;
  strains.b[1] << 0.2, 0.1, 0.1, 0.1;
  const Model::Pointer model = *Model::from_data(sample_basis(strains));
  const Sample s{strains, model, *vibrating_system(*model, alpha, beta)};
  const double unit = (*reduce_force(*model, 3, {0.0, 0.0, 1.0}))[0];
  const double load = 0.6 * (alpha + beta) / unit;
  FourierSeries force = FourierSeries::Zero(2, 3);
  force.col(2) = *reduce_force(*model, 3, {0.0, 0.0, load});
  CurveOptions options = plain_options(12);
  options.longest_step = 0.2;
  const Result<MotionCurve> curve = response_curve(s.system, {force, 1.3, 0.6}, options);
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  std::vector<double> folds;
  for (const Bifurcation& found : curve->bifurcations)
    if (found.kind == BifurcationKind::kFold) folds.push_back(found.point.omega);
  ASSERT_EQ(folds.size(), 2U);
  const double low = std::min(folds[0], folds[1]), high = std::max(folds[0], folds[1]);
  int on_branch[3] = {0, 0, 0}, branch = 0;
  for (std::size_t i = 1; i < curve->points.size(); ++i) {
    const CurvePoint& point = curve->points[i];
    if (point.stable != curve->points[i - 1].stable) ++branch;
    const double width = high - low;
    if (point.omega < low + 0.2 * width || point.omega > high - 0.2 * width) continue;
    if (on_branch[branch]++ > 0) continue;
    const double distance = distance_after(s, point, load, alpha, beta, 0.01, 60, 400);
    if (point.stable)
      EXPECT_LE(distance, 1e-4) << point.omega;
    else
      EXPECT_GT(distance, 1e-2) << point.omega;
  }
  EXPECT_EQ(branch, 2);
  for (const int count : on_branch) EXPECT_GT(count, 0);
}

// From rest, under the load that `response_curve` has, and with the same ratios: the transient of
// 100 periods has died out by e^-30.
TEST(Response, ABodyWithTheSameRatiosSettlesOntoItsAmplitude) {
  const StrainModel strains = random_strain_model(spread_omega(3, 1.0, 4.0), 0.4, 3);
  const Model::Pointer model = *Model::from_data(sample_basis(strains));
  DampingRatios ratios;
  ratios.of_modes = {0.05, 0.08, 0.02};
  const VibratingSystem system =
      *vibrating_system(*model, 0.0, 0.0, modal_rates(ratios, model->lambda()));
  const Eigen::VectorXd unit = *reduce_force(*model, 3, {0.0, 0.0, 1.0});
  const double load = 0.02 / std::abs(unit[0]);
  FourierSeries force = FourierSeries::Zero(3, 3);
  force.col(2) = load * unit;
  const Result<MotionCurve> curve = response_curve(system, {force, 0.7, 1.2}, plain_options(9));
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  std::size_t seen = 0, nonlinear = 0;
  for (std::size_t i = 0; i < curve->points.size(); i += curve->points.size() / 4) {
    const CurvePoint& point = curve->points[i];
    const double period = 2.0 * std::numbers::pi / point.omega;
    constexpr int kSteps = 200;
    IntegratorOptions options{.step = period / kSteps};
    options.tolerance = 1e-10;
    put_damping(ratios, options);
    Body body = std::move(*Body::create(model, "ep4", options));
    const Signal sine{.kind = SignalKind::kSine, .frequency = 1.0 / period};
    ASSERT_TRUE(body.add_load(sine, 3, {0.0, 0.0, load}));
    for (int n = 0; n < 100 * kSteps; ++n) ASSERT_TRUE(body.step().converged);
    double largest = 0.0, expected = 0.0;
    for (int n = 0; n < kSteps; ++n) {
      ASSERT_TRUE(body.step().converged);
      largest = std::max(largest, std::abs(body.state().q[0]));
      const double angle = 2.0 * std::numbers::pi * (n + 1) / kSteps;
      expected = std::max(expected,
                          std::abs(point.motion.row(0).dot(fourier_row(point.harmonics(), angle))));
    }
    EXPECT_NEAR(largest, expected, 1e-4 * expected) << point.omega;
    ++seen;
    if (point.motion.col(0).norm() > 0.01 * expected) ++nonlinear;  // a mean displacement
  }
  EXPECT_GE(seen, 4U);
  EXPECT_GE(nonlinear, 1U);
}

TEST(Backbone, ItsMotionsReturnAfterTheirPeriodUnderEp4) {
  const Sample s = sample(spread_omega(3, 1.0, 5.0), 0.6, 0.0, 0.0);
  CurveOptions options = plain_options(5);
  options.most_harmonics = 45;
  options.harmonic_share = 1e-9;
  const Result<MotionCurve> curve = backbone_curve(s.system, {0, {}, 0.3}, options);
  ASSERT_TRUE(curve) << curve.error().message;
  ASSERT_EQ(curve->end, CurveEnd::kDone);
  for (std::size_t i = 0; i < curve->points.size(); i += 8) {
    const CurvePoint& point = curve->points[i];
    // ep4 with 4000 steps a period is converged to 1e-9.
    EXPECT_LE(distance_after(s, point, 0.0, 0.0, 0.0, 0.0, 1, 4000), 1e-6) << point.amplitude;
    const State start = state_of(point);
    const double energy = testing::strain_energy(s.strains, start.q) + 0.5 * start.p.squaredNorm();
    EXPECT_NEAR(mean_energy(s.system, point.motion, point.omega), energy, 1e-7 * energy);
  }
}

TEST(Backbone, OfALinearModelKeepsItsFrequency) {
  const Model::Pointer model = testing::linear_model(spread_omega(3, 1.0, 5.3));
  const VibratingSystem system = *vibrating_system(*model, 0.0, 0.0);
  for (const Eigen::Index mode : {0, 1, 2}) {
    const Result<MotionCurve> curve = backbone_curve(system, {mode, {}, 0.5}, plain_options(3));
    ASSERT_TRUE(curve) << curve.error().message;
    const double omega = std::sqrt(model->lambda()[mode]);
    for (const CurvePoint& point : curve->points) EXPECT_NEAR(point.omega, omega, 1e-11 * omega);
  }
}

// The monodromy by Runge-Kutta steps of the closed form; its own derivatives by differences of the
// damping force, which is quadratic in q.
Eigen::MatrixXd stepped_monodromy(const Sample& s, const CurvePoint& point, double alpha,
                                  double beta, int steps) {
  const Eigen::Index r = s.model->modes(), H = point.harmonics();
  const auto slope = [&](double theta, const Eigen::MatrixXd& y) {
    const Eigen::VectorXd q = point.motion * fourier_row(H, theta);
    const Eigen::VectorXd v = point.omega * point.motion * fourier_slope_row(H, theta);
    Eigen::MatrixXd out(2 * r, 2 * r);
    out.topRows(r) = y.bottomRows(r);
    const double e = 1e-5;
    for (Eigen::Index j = 0; j < 2 * r; ++j) {
      const Eigen::VectorXd dq = y.col(j).head(r), dv = y.col(j).tail(r);
      // Exact up to the cubic part, whose difference has an error of e^2.
      const auto force = [&](double sign) {
        return Eigen::VectorXd(
            testing::strain_force(s.strains, q + sign * e * dq) +
            beta * testing::strain_damping_force(s.strains, q + sign * e * dq, v + sign * e * dv));
      };
      out.col(j).tail(r) = -(force(1.0) - force(-1.0)) / (2.0 * e) - alpha * dv;
    }
    return Eigen::MatrixXd(out / point.omega);
  };
  Eigen::MatrixXd y = Eigen::MatrixXd::Identity(2 * r, 2 * r);
  const double h = 2.0 * std::numbers::pi / steps;
  for (int n = 0; n < steps; ++n) {
    const Eigen::MatrixXd k1 = slope(n * h, y), k2 = slope((n + 0.5) * h, y + 0.5 * h * k1);
    const Eigen::MatrixXd k3 = slope((n + 0.5) * h, y + 0.5 * h * k2);
    const Eigen::MatrixXd k4 = slope((n + 1.0) * h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y;
}

TEST(Floquet, MultipliersAreThoseOfStepping) {
  const double alpha = 0.03, beta = 0.02;
  const Sample s = sample(spread_omega(3, 1.0, 5.0), 0.6, alpha, beta);
  CurvePoint point;
  point.motion = random_series(3, 3, 0.1);
  point.omega = 0.9;
  const Eigen::MatrixXd stepped = stepped_monodromy(s, point, alpha, beta, 2000);
  const Eigen::VectorXcd exact = stepped.eigenvalues();
  double before = 0.0;
  for (const int steps : {32, 64, 128}) {
    double worst = 0.0;
    for (const auto& value : Floquet(s.system).multipliers(point.motion, point.omega, steps)) {
      double nearest = 1e300;
      for (const auto& other : exact) nearest = std::min(nearest, std::abs(value - other));
      worst = std::max(worst, nearest);
    }
    // Order six: 64 times smaller with half the step. The differences above err by 1e-6.
    if (before > 1e-4) {
      EXPECT_LT(worst, before / 30.0);
    }
    before = worst;
  }
  EXPECT_LE(before, 2e-6);
}

TEST(Floquet, TheProductOfTheMultipliersIsThatOfLiouville) {
  const double alpha = 0.1;
  const Sample s = sample(spread_omega(3, 1.0, 5.0), 0.6, alpha, 0.0);
  const FourierSeries motion = random_series(3, 4, 0.1);
  const double omega = 0.9;
  // exp of minus the integral of the trace of the rates.
  const double exact = std::exp(-3.0 * alpha * 2.0 * std::numbers::pi / omega);
  const auto error = [&](int steps) {
    return std::abs(Floquet(s.system).multipliers(motion, omega, steps).prod() / exact - 1.0);
  };
  // Order six: 64 times smaller with half the step.
  EXPECT_LT(error(128), error(64) / 30.0);
  EXPECT_LT(error(256), 1e-8);
}

TEST(StaticState, BeyondBucklingIsRefusedWithTheFractionOfTheForce) {
  // x + 3 c x^2 + 2 q x^3 with a limit point: no state at rest beyond it near the first.
  const std::vector<double> cubic{-1.0}, quartic{0.6};
  const Potential potential = *Potential::create(Eigen::VectorXd::Constant(1, 1.0), cubic, quartic);
  // R = x - 3 x^2 + 2.4 x^3, R' = 0 at x = (6 - sqrt(36 - 28.8))/14.4.
  const double limit = (6.0 - std::sqrt(36.0 - 28.8)) / 14.4;
  const double most = limit - 3.0 * limit * limit + 2.4 * std::pow(limit, 3);
  const auto below = static_state(potential, Eigen::VectorXd::Constant(1, 0.99 * most));
  ASSERT_TRUE(below);
  EXPECT_LT((*below)[0], limit);
  const auto beyond = static_state(potential, Eigen::VectorXd::Constant(1, 2.0 * most));
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().kind, ErrorKind::kContent);
  EXPECT_NE(beyond.error().message.find("static instability"), std::string::npos);
  EXPECT_NE(beyond.error().message.find("at 0.5 of it"), std::string::npos)
      << beyond.error().message;
}

// A force that bends a hardening body 2000 times as far as where the stiffness has doubled: the
// first part of it must be small.
TEST(StaticState, UnderALargeForceItIsTheRootOfTheCubic) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.0});
  for (const double x : {1.0, 40.0, 2000.0}) {
    const Eigen::VectorXd force = Eigen::VectorXd::Constant(1, x + x * x * x);
    const Result<Eigen::VectorXd> state = static_state(system.potential, force);
    ASSERT_TRUE(state) << x << ": " << state.error().message;
    EXPECT_NEAR((*state)[0], x, 1e-10 * x);
  }
}

TEST(Response, WithoutDampingItIsUnboundedAtResonance) {
  const Model::Pointer model = testing::linear_model(spread_omega(2, 1.0, 4.0));
  const VibratingSystem system = *vibrating_system(*model, 0.0, 0.0);
  CurveOptions options = plain_options(1);
  options.largest_amplitude = 1e3;
  const FourierSeries force = cosine_force(Eigen::VectorXd::Ones(2));
  const Result<MotionCurve> curve = response_curve(system, {force, 0.5, 2.0}, options);
  ASSERT_TRUE(curve);
  EXPECT_EQ(curve->end, CurveEnd::kUnbounded);
  EXPECT_NEAR(curve->points.back().omega, 1.0, 1e-3);
  EXPECT_GT(curve->points.size(), 10U);
}

TEST(Response, WrongRequestsAreRefused) {
  const VibratingSystem system = system_of({1.0, 1.0, 0.02});
  const FourierSeries force = cosine_force(Eigen::VectorXd::Constant(1, 0.1));
  for (const auto& [from, to] : {std::pair(0.0, 1.0),
                                 {1.0, 0.0},
                                 {-1.0, 2.0},
                                 {1.0, 1.0},
                                 {1.0, std::numeric_limits<double>::infinity()}}) {
    const Result<MotionCurve> curve = response_curve(system, {force, from, to}, plain_options(3));
    ASSERT_FALSE(curve);
    EXPECT_EQ(curve.error().kind, ErrorKind::kContent);
  }
  const Result<MotionCurve> short_of =
      response_curve(system, {with_harmonics(force, 5), 0.5, 2.0}, plain_options(3));
  ASSERT_FALSE(short_of);
  EXPECT_NE(short_of.error().message.find("harmonic 5"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
