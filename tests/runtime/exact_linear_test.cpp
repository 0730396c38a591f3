// ep4 on a linear model: the solution itself, coordinate by coordinate.
#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/body.h"
#include "runtime/crowd.h"
#include "tests/support/dynamics.h"
#include "tests/support/linear_model.h"
#include "tests/support/quad_exponential.h"

namespace tremolo {
namespace {

using testing::linear_model;
using testing::Quad;
using testing::QuadMatrix;

Eigen::VectorXd constant(double value) {
  return Eigen::VectorXd::Constant(1, value);
}

// From the smallest step to the stiffest and most damped, at and about critical damping.
std::vector<std::pair<double, double>> dampings_and_stiffnesses() {
  std::vector<std::pair<double, double>> pairs;
  for (double b = 1e-16; b < 2e9; b *= 13.7) {
    for (double a = 1e-8; a < 2e6; a *= 23.1) pairs.emplace_back(a, b);
    pairs.emplace_back(0.0, b);
    for (const double beside : {0.0, 1e-15, -1e-15, 1e-10, -1e-10, 1e-3, -1e-3, 0.3, -0.3})
      pairs.emplace_back(2.0 * std::sqrt(b) * (1.0 + beside), b);
  }
  for (const double a : {0.0, 1e-9, 0.1, 1.9, 3.9, 4.1, 1e3, 1e6}) pairs.emplace_back(a, 0.0);
  // The boundary between two forms.
  for (const double a : {3.9, 3.99999, 4.0, 4.00001, 4.2, 5.0, 6.0})
    for (const double b : {1.0, 3.99999, 4.0, 4.00001, 6.2, 7.9, 8.1}) pairs.emplace_back(a, b);
  return pairs;
}

TEST(LinearResponse, IsThatOfTheMatrixExponentialFromFreeToFarOverdamped) {
  for (const std::pair<double, double>& pair : dampings_and_stiffnesses()) {
    const double a = pair.first, b = pair.second;  // clang 14 captures no structured binding
    QuadMatrix<7> matrix{};                        // u, u', integrals
    matrix[0][1] = 1;
    matrix[1][0] = -Quad(b);
    matrix[1][1] = -Quad(a);
    matrix[2][0] = 1;
    for (std::size_t k = 3; k < 7; ++k) matrix[k][k - 1] = 1;
    const QuadMatrix<7> truth = testing::exponential(matrix);
    const LinearResponse response = linear_response(a, b);
    // Besides rounding, the effect of the phase's rounding: sqrt(b) turns.
    const double rounding = 4e-15 + 4e-16 * std::sqrt(b);
    const double period = std::min(1.0, 1.0 / std::sqrt(b));
    const auto expect = [&](double value, const Quad& exact, double size, const char* what) {
      const auto reference = static_cast<double>(exact);
      EXPECT_NEAR(value, reference, rounding * std::max(std::abs(reference), size))
          << what << ", a = " << a << ", b = " << b;
    };
    expect(response.velocity, truth[1][1], 1.0, "velocity");
    expect(response.place, truth[0][0], 1.0, "place");
    expect(response.integral[0], truth[0][1], period, "u");
    expect(response.integral[1], truth[2][1], period * period, "first integral");
    for (std::size_t k = 2; k < 6; ++k) {
      const auto reference = static_cast<double>(truth[k + 1][1]);
      EXPECT_NEAR(response.integral[k], reference, 5e-14 * reference)
          << k << ", a = " << a << ", b = " << b;
    }
  }
}

// One coordinate with what pushes it inside a step: f = g0 + g1 s + g2 s^2.
struct Oscillator {
  double lambda, rate, step;
  double f0, mean, f1;

  // (q, p) after the fraction s of the step, from (q0, p0).
  std::pair<double, double> at(double s, double q0, double p0) const {
    const Quad h = Quad(s) * step;
    QuadMatrix<5> matrix{};  // q, p, 1, s, s^2
    matrix[0][1] = h;
    matrix[1][0] = -h * lambda;
    matrix[1][1] = -h * rate;
    matrix[1][2] = h * f0;
    matrix[1][3] = h * (Quad(6) * mean - Quad(4) * f0 - Quad(2) * f1);
    matrix[1][4] = h * (Quad(3) * f0 + Quad(3) * f1 - Quad(6) * mean);
    matrix[3][2] = s;
    matrix[4][3] = Quad(2) * s;
    const QuadMatrix<5> truth = testing::exponential(matrix);
    return {static_cast<double>(truth[0][0] * q0 + truth[0][1] * p0 + truth[0][2]),
            static_cast<double>(truth[1][0] * q0 + truth[1][1] * p0 + truth[1][2])};
  }
};

StepLoad load_of(const Oscillator& o) {
  return {constant(o.f0), constant(o.mean), constant(o.f1), true};
}

TEST(ExactLinear, OneStepIsTheSolutionUnderMassAndStiffnessDampingAndAnyQuadraticLoad) {
  // h omega from 0.003 to 300, D h up to 1.5e6.
  for (const double step : {1.0 / 44100.0, 3e-3, 0.1})
    for (const double omega : {1.0, 40.0, 900.0, 3000.0})
      for (const auto& [alpha, beta] :
           {std::pair{0.0, 0.0}, {0.7, 0.0}, {0.0, 1e-5}, {20.0, 2e-3}, {2e4, 0.0}, {1e7, 1.0}}) {
        const Oscillator o{omega * omega, alpha + beta * omega * omega, step, 3.0, -7.0, 40.0};
        const Model::Pointer model = linear_model(constant(omega));
        const auto integrator =
            testing::make("ep4", model, {.step = step, .alpha = alpha, .beta = beta});
        State state{constant(0.3), constant(-2.0)};
        const StepReport report = integrator->step(state, load_of(o));
        ASSERT_TRUE(report.converged);
        EXPECT_EQ(report.iterations, 0);
        const auto [q, p] = o.at(1.0, 0.3, -2.0);
        // Sizes that come in: amplitudes, and how far and fast the load pushes.
        const double reach = std::min({step * step, 1.0 / o.lambda, step / o.rate});
        const double q_size = 0.3 + 2.0 * std::min(step, 1.0 / omega) + 40.0 * reach;
        const double p_size = 2.0 + 0.3 * omega + 40.0 * std::min(step, 1.0 / o.rate);
        const double rounding = 2e-15 + 1e-15 * step * omega;
        EXPECT_NEAR(state.q[0], q, rounding * q_size) << step << ' ' << omega << ' ' << o.rate;
        EXPECT_NEAR(state.p[0], p, rounding * p_size) << step << ' ' << omega << ' ' << o.rate;
      }
}

// The integral over the step of what integrand(q, p, s) says, s, by Gauss's rule of five points on
// 32 pieces of the true motion.
template <class Integrand>
double integral(const Oscillator& o, double q0, double p0, Integrand&& integrand) {
  constexpr std::array<std::pair<double, double>, 5> kRule = {
      {{-0.9061798459386640, 0.2369268850561891},
       {-0.5384693101056831, 0.4786286704993665},
       {0.0, 0.5688888888888889},
       {0.5384693101056831, 0.4786286704993665},
       {0.9061798459386640, 0.2369268850561891}}};
  double sum = 0.0;
  for (int piece = 0; piece < 32; ++piece)
    for (const auto& [node, weight] : kRule) {
      const double s = (piece + 0.5 + 0.5 * node) / 32.0;
      const auto [q, p] = o.at(s, q0, p0);
      sum += weight / 64.0 * integrand(q, p, s);
    }
  return o.step * sum;
}

TEST(ExactLinear, WorkAndDissipationAreTheirIntegralsOverTheTrueMotion) {
  const double step = 3e-3;
  for (const double omega : {2.0, 300.0, 2000.0})
    for (const double rate : {0.0, 5.0, 2.0 * omega, 3000.0}) {
      const Oscillator o{omega * omega, rate, step, 3.0, -7.0, 40.0};
      const auto integrator =
          testing::make("ep4", linear_model(constant(omega)), {.step = step, .alpha = rate});
      State state{constant(0.01), constant(-2.0)};
      const State before = state;
      const StepLoad load = load_of(o);
      const StepReport report = integrator->step(state, load);
      const double work = integral(o, before.q[0], before.p[0], [&](double, double p, double s) {
        Eigen::VectorXd f(1);
        load_at(load, s, f);
        return f[0] * p;
      });
      const double taken = integral(o, before.q[0], before.p[0],
                                    [&](double, double p, double) { return rate * p * p; });
      const double reported = load.average.dot(state.q - before.q) + report.extra_work;
      const double size = 2.0 + 0.5 * o.lambda * 1e-4;  // J, of the motion
      EXPECT_NEAR(reported, work, 1e-13 * size) << omega << ' ' << rate;
      EXPECT_NEAR(report.dissipated, taken, 1e-13 * size) << omega << ' ' << rate;
      if (rate == 0.0) {
        EXPECT_EQ(report.dissipated, 0.0);
      }
    }
}

// 200 coordinates to 20 kHz, as in a sound.
Eigen::VectorXd audible() {
  return 2.0 * M_PI * testing::spread_omega(200, 50.0, 20000.0);
}

TEST(ExactLinear, StepsOfAnyLengthLeadToTheSamePlace) {
  const Model::Pointer model = linear_model(audible());
  const Eigen::VectorXd force = testing::random_vector(200, 1e4, 1);
  const std::vector<Load> loads = {{{.kind = SignalKind::kSquare, .duration = 0.01}, force}};
  const auto place_after = [&](int steps) {
    const IntegratorOptions options{.step = 0.04 / steps, .alpha = 3.0, .beta = 1e-8};
    State state{Eigen::VectorXd::Zero(200), Eigen::VectorXd::Zero(200)};
    const auto integrator = testing::make("ep4", model, options);
    testing::run(*integrator, state, loads, options.step, steps);
    return state;
  };
  const State coarse = place_after(4), fine = place_after(1764);  // 44.1 kHz
  // 5000 radians of the highest, each rounded.
  EXPECT_LE((coarse.q - fine.q).norm(), 2e-12 * fine.q.norm());
  EXPECT_LE((coarse.p - fine.p).norm(), 2e-12 * fine.p.norm());
  EXPECT_GE(fine.q.cwiseAbs().minCoeff(), 0.0);
  EXPECT_GE(fine.q.norm(), 1e-6) << "nothing moved";
}

TEST(ExactLinear, SmoothLoadIsFollowedToFourthOrder) {
  // f = sin(w t) on q'' + q omega^2: the solution in closed form.
  const double omega = 50.0, w = 2.0 * M_PI * 4.0, duration = 0.6;
  const auto error = [&](int steps) {
    const double step = duration / steps;
    State state{constant(0.0), constant(0.0)};
    const auto integrator = testing::make("ep4", linear_model(constant(omega)), {.step = step});
    testing::run(*integrator, state, {{{.kind = SignalKind::kSine, .frequency = 4.0}, constant(1)}},
                 step, steps);
    const double exact =
        (std::sin(w * duration) - w / omega * std::sin(omega * duration)) / (omega * omega - w * w);
    return std::abs(state.q[0] - exact);
  };
  EXPECT_NEAR(std::log2(error(40) / error(80)), 4.0, 0.1);
}

TEST(ExactLinear, UndampedEnergyStaysForAMillionSteps) {
  const Eigen::VectorXd omega = testing::spread_omega(3, 40.0, 5000.0);  // h omega up to 15
  const auto integrator = testing::make("ep4", linear_model(omega), {.step = 3e-3});
  const State start{testing::random_vector(3, 0.1, 1), testing::random_vector(3, 20.0, 2)};
  State state = start;
  testing::run(*integrator, state, {}, 3e-3, 1000000);
  // The rounded matrix drifts by 1e-16 a step, 1e-10 here; rounding at random makes 1e-13.
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto energy = [&](const State& s) {
      return 0.5 * (s.p[i] * s.p[i] + omega[i] * omega[i] * s.q[i] * s.q[i]);
    };
    EXPECT_NEAR(energy(state) / energy(start), 1.0, 2e-12) << i;
  }
}

TEST(ExactLinear, BodyOfAThousandCoordinatesStepsAtAudioRate) {
  const Model::Pointer model = linear_model(2.0 * M_PI * testing::spread_omega(1000, 20.0, 2e4));
  Result<Body> body = Body::create(model, "ep4", {.step = 1.0 / 44100.0, .beta = 1e-8});
  ASSERT_TRUE(body);
  EXPECT_EQ(body->integrator().name(), "ep4");
  ASSERT_TRUE(body->apply_force(3, {0.0, 0.0, 1.0}, 40));
  const auto before = std::chrono::steady_clock::now();
  for (int k = 0; k < 2000; ++k) ASSERT_TRUE(body->step().converged);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - before;
  EXPECT_EQ(body->counts().iterations, 0);
  EXPECT_GT(body->energy().total(), 0.0);
  EXPECT_NEAR(body->energy().total(), body->sums().work - body->sums().dissipated,
              1e-12 * body->sums().work);
  // 0.01 s here; a factorisation a step takes minutes.
  EXPECT_LT(spent.count(), 20.0);
}

TEST(ExactLinear, DampedMotionComesToRestBeforeItsNumbersAreDenormal) {
  const auto integrator =
      testing::make("ep4", linear_model(audible()), {.step = 3e-3, .alpha = 500.0});
  State state{testing::random_vector(200, 0.1, 1), testing::random_vector(200, 20.0, 2)};
  for (int k = 0; k < 2000; ++k) {
    ASSERT_TRUE(integrator->step(state, make_step_load(200)).converged);
    for (const Eigen::VectorXd* x : {&state.q, &state.p})
      ASSERT_TRUE(((x->array() == 0.0) || (x->array().abs() > 1e-300)).all()) << k;
  }
  EXPECT_EQ(state.q, Eigen::VectorXd::Zero(200));
  EXPECT_EQ(state.p, Eigen::VectorXd::Zero(200));
}

TEST(ExactLinear, NumbersThatAreNotFiniteAreNoConvergenceAndChangeNothing) {
  for (const double alpha : {0.0, 1.0}) {
    const auto integrator =
        testing::make("ep4", linear_model(audible()), {.step = 3e-3, .alpha = alpha});
    const State before{testing::random_vector(200, 0.1, 1), testing::random_vector(200, 20.0, 2)};
    State state = before;
    StepLoad load = make_step_load(200);
    load.average[7] = std::nan("");
    load.active = true;
    const StepReport report = integrator->step(state, load);
    EXPECT_FALSE(report.converged);
    EXPECT_FALSE(std::isfinite(report.residual)) << "a program detects overflow in this way";
    state.q[3] = INFINITY;
    EXPECT_FALSE(integrator->step(state, make_step_load(200)).converged);
    state.q[3] = before.q[3];
    EXPECT_EQ(state.q, before.q);
    EXPECT_EQ(state.p, before.p);
  }
}

TEST(ExactLinear, BodiesOfAWorldTakeTheSameSteps) {
  const Model::Pointer model = linear_model(audible());
  Result<Crowd> world = Crowd::create(1);
  ASSERT_TRUE(world);
  GroupOptions options;
  options.integrator = "ep4";
  options.options.alpha = 2.0;
  const Result<GroupId> group = world->add_group(model, options);
  ASSERT_TRUE(group);
  const BodyId id = *world->add_body(*group);
  Body body = std::move(*Body::create(model, "ep4", options.options));
  ASSERT_TRUE(world->apply_force(id, 3, {0.0, 0.0, 1.0}, 5));
  ASSERT_TRUE(body.apply_force(3, {0.0, 0.0, 1.0}, 5));
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(world->step().failed.empty());
    ASSERT_TRUE(body.step().converged);
  }
  EXPECT_EQ(world->state(id)->q, body.state().q);
  EXPECT_EQ(world->state(id)->p, body.state().p);
}

}  // namespace
}  // namespace tremolo
