// The methods that are there for contrast, and the fourth-order splitting: their maps on one linear
// oscillator, digit by digit, where they stop being stable, and what they report.
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;

Model::Pointer oscillator(double step_omega) {
  return testing::make_model(testing::random_strain_model(
      Eigen::VectorXd::Constant(1, step_omega / kOscillatorStep), 0.0, 1));
}

// One coordinate: (q, p).
using Pair = Eigen::Vector2d;
struct Forcing {
  double start, average, end;
  double middle() const { return 1.5 * average - 0.25 * (start + end); }  // of the quadratic
};

Pair slope(const Pair& z, double f, double lambda, double rate) {
  return {z[1], f - lambda * z[0] - rate * z[1]};
}

Pair explicit_euler_step(const Pair& z, const Forcing& f, double lambda, double rate) {
  return z + kOscillatorStep * slope(z, f.average, lambda, rate);
}

Pair implicit_euler_step(const Pair& z, const Forcing& f, double lambda, double rate) {
  // p1 (1 + h D + h^2 lambda) = p0 + h (f - lambda q0)
  const double p = (z[1] + kOscillatorStep * (f.average - lambda * z[0])) /
                   (1.0 + kOscillatorStep * rate + kOscillatorStep * kOscillatorStep * lambda);
  return {z[0] + kOscillatorStep * p, p};
}

Pair rk2_step(const Pair& z, const Forcing& f, double lambda, double rate) {
  const Pair middle = z + 0.5 * kOscillatorStep * slope(z, f.start, lambda, rate);
  return z + kOscillatorStep * slope(middle, f.average, lambda, rate);
}

Pair rk4_step(const Pair& z, const Forcing& f, double lambda, double rate) {
  const double h = kOscillatorStep;
  const Pair k1 = slope(z, f.start, lambda, rate);
  const Pair k2 = slope(z + 0.5 * h * k1, f.middle(), lambda, rate);
  const Pair k3 = slope(z + 0.5 * h * k2, f.middle(), lambda, rate);
  const Pair k4 = slope(z + h * k3, f.end, lambda, rate);
  return z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

// Steps an oscillator from (0.02, 3) sixty times under random loads. After each step `judge` moves
// its own (q, p) by the recurrence and compares.
void follow(Integrator& integrator,
            const std::function<void(const StepLoad&, const State&, Pair&, unsigned)>& judge) {
  State state{Eigen::VectorXd::Constant(1, 0.02), Eigen::VectorXd::Constant(1, 3.0)};
  Pair z(0.02, 3.0);
  StepLoad load = make_step_load(1);
  for (unsigned k = 0; k < 60; ++k) {
    testing::randomize(load, 300.0, 3 * k);
    ASSERT_TRUE(integrator.step(state, load).converged);
    judge(load, state, z, k);
  }
}

using PairStep = Pair (*)(const Pair&, const Forcing&, double, double);

TEST(ContrastRecurrence, EveryMethodFollowsItsOwnDampedAndForced) {
  const std::array<std::pair<const char*, PairStep>, 4> methods = {{
      {"explicit-euler", explicit_euler_step},
      {"implicit-euler", implicit_euler_step},
      {"rk2", rk2_step},
      {"rk4", rk4_step},
  }};
  const double alpha = 0.7, beta = 2e-4;
  for (const auto& [name, step] : methods)
    for (const double x : {0.1, 0.5, 1.7}) {
      const double lambda = x * x / (kOscillatorStep * kOscillatorStep);
      const auto integrator = make(name, oscillator(x), oscillator_options(alpha, beta));
      follow(*integrator, [&](const StepLoad& load, const State& state, Pair& z, unsigned k) {
        z = step(z, {load.start[0], load.average[0], load.end[0]}, lambda, alpha + beta * lambda);
        // Sizes of this motion; the growing ones amplify their rounding.
        const double omega = x / kOscillatorStep, p_scale = 10.0 + std::hypot(omega * z[0], z[1]);
        ASSERT_NEAR(state.q[0], z[0], kOscillatorRounding * p_scale / omega)
            << name << ' ' << x << ' ' << k;
        ASSERT_NEAR(state.p[0], z[1], kOscillatorRounding * p_scale)
            << name << ' ' << x << ' ' << k;
      });
    }
}

// One undamped step at h omega = y as a matrix on (omega q, p).
Eigen::Matrix2d map_of(std::string_view name, double y) {
  const double omega = y / kOscillatorStep;
  const auto integrator = make(name, oscillator(y), oscillator_options());
  State from_q{Eigen::VectorXd::Constant(1, 1.0 / omega), Eigen::VectorXd::Zero(1)};
  State from_p{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1)};
  testing::run(*integrator, from_q, {}, kOscillatorStep, 1);
  testing::run(*integrator, from_p, {}, kOscillatorStep, 1);
  Eigen::Matrix2d map;
  map << omega * from_q.q[0], omega * from_p.q[0], from_q.p[0], from_p.p[0];
  return map;
}

// By how much one step multiplies the amplitude: the map is a rotation times this.
double amplification(std::string_view name, double y) {
  return std::sqrt(map_of(name, y).determinant());
}

TEST(Amplification, IsTheClosedFormOfEachContrastMethod) {
  for (const double y : {0.01, 0.1, 0.5, 1.0, 2.0, 2.9}) {
    EXPECT_NEAR(amplification("explicit-euler", y), std::hypot(1.0, y),
                kOscillatorRounding * (1.0 + y));
    EXPECT_NEAR(amplification("implicit-euler", y), 1.0 / std::hypot(1.0, y), kOscillatorRounding);
    EXPECT_NEAR(amplification("rk2", y), std::sqrt(1.0 + std::pow(y, 4) / 4.0),
                kOscillatorRounding * 5.0);
    EXPECT_NEAR(amplification("rk4", y),
                std::sqrt(1.0 - std::pow(y, 6) / 72.0 + std::pow(y, 8) / 576.0),
                kOscillatorRounding * 5.0);
  }
}

TEST(Amplification, OfRungeKuttaFourEndsAtTheRootOfEight) {
  const double limit = std::sqrt(8.0);
  EXPECT_NEAR(amplification("rk4", limit), 1.0, kOscillatorRounding * 5.0);
  EXPECT_LT(amplification("rk4", limit - 1e-3), 1.0);
  EXPECT_GT(amplification("rk4", limit + 1e-3), 1.0);
}

TEST(Amplification, ImplicitEulerIsStableAtAnyStep) {
  for (const double y : {10.0, 1e3, 1e5}) EXPECT_LE(amplification("implicit-euler", y), 1.0 / y);
}

// A symplectic map of one oscillator is stable while its half trace lies within [-1, 1].
double stability_limit(std::string_view name) {
  const auto stable = [&](double y) { return std::abs(0.5 * map_of(name, y).trace()) <= 1.0; };
  double low = 0.5, high = low;
  while (stable(high)) low = high, high += 1e-3;
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

TEST(Verlet4, IsStableToThreePointOneSix) {
  EXPECT_NEAR(stability_limit("verlet"), 2.0, 1e-6);
  // Measured; pi is near, where every map of a symmetric splitting is close to -1.
  EXPECT_NEAR(stability_limit("verlet4"), 3.16346507, 1e-6);
}

TEST(Stability, OfSplittingMethodsIsThatOfVerletOnLowRowsAndUnlimitedOnHighRows) {
  for (const char* name : {"imexv", "imexv-adaptive", "imexv-linear", "imexv-coupled"}) {
    IntegratorOptions options = oscillator_options();
    options.split = {.rule = SplitRule::kCount, .count = 1};
    const auto half_trace = [&](double y) {
      const auto integrator = make(name, oscillator(y), options);
      State from_q{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
      State from_p{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1)};
      testing::run(*integrator, from_q, {}, kOscillatorStep, 1);
      testing::run(*integrator, from_p, {}, kOscillatorStep, 1);
      return std::abs(0.5 * (from_q.q[0] + from_p.p[0]));
    };
    EXPECT_LT(half_trace(1.99), 1.0) << name;
    if (std::string_view(name) != "imexv-adaptive") {
      EXPECT_GT(half_trace(2.01), 1.0) << name;
    }
    options.split.count = 0;
    for (const double y : {2.01, 10.0, 100.0}) EXPECT_LT(half_trace(y), 1.0) << name << ", " << y;
  }
  for (const char* name : {"midpoint", "newmark", "avf", "ep2", "ep4"})
    for (const double y : {0.1, 2.01, 10.0, 100.0})
      EXPECT_LT(std::abs(0.5 * map_of(name, y).trace()), 1.0) << name << ", " << y;
}

TEST(Verlet4, KeepsTheAreaOfThePhasePlane) {
  for (const double y : {0.1, 1.0, 3.0})
    EXPECT_NEAR(map_of("verlet4", y).determinant(), 1.0, kOscillatorRounding * 5.0) << y;
}

TEST(Verlet4, TurnsByItsAngleUpToASmallFifthPower) {
  // theta = y + c y^5, c = -1.5e-5: that of three Verlet steps composed to fourth order is 4400
  // times that, -0.0666.
  for (const double y : {0.2, 0.3}) {
    const double theta = std::acos(0.5 * map_of("verlet4", y).trace());
    EXPECT_NEAR((theta - y) / std::pow(y, 5), -1.5e-5, 0.05e-5) << y;
  }
}

// Its recurrence, written out from the paper's coefficients with drift and kick as matrices.
TEST(Verlet4, FollowsItsRecurrenceDampedAndForced) {
  const double b1 = 0.0829844064174052, b2 = 0.396309801498368, b3 = -0.0390563049223486;
  const double a1 = 0.245298957184271, a2 = 0.604872665711080, a3 = 0.5 - a1 - a2;
  const std::array a = {a1, a2, a3, a3, a2, a1};
  const std::array b = {b1, b2, b3, 1.0 - 2.0 * (b1 + b2 + b3), b3, b2, b1};
  for (const auto& [alpha, beta] : {std::pair{0.0, 0.0}, {0.7, 0.0}, {0.7, 2e-4}})
    for (const double x : {0.1, 0.5, 1.7}) {
      const double lambda = x * x / (kOscillatorStep * kOscillatorStep),
                   rate = alpha + beta * lambda;
      const auto integrator = make("verlet4", oscillator(x), oscillator_options(alpha, beta));
      follow(*integrator, [&](const StepLoad& load, const State& state, Pair& z, unsigned k) {
        double t = 0.0;
        for (std::size_t i = 0; i < b.size(); ++i) {
          Eigen::VectorXd f(1);
          load_at(load, t, f);
          z[1] += b[i] * kOscillatorStep * (f[0] - lambda * z[0]);
          if (i == a.size()) break;
          const double s = a[i] * kOscillatorStep;
          z[0] += rate == 0.0 ? s * z[1] : z[1] * (1.0 - std::exp(-rate * s)) / rate;
          z[1] *= std::exp(-rate * s);
          t += a[i];
        }
        // 1 - e^-x loses 1/x of its digits, here up to 1/2e-3, in a term of h p.
        const double omega = x / kOscillatorStep, p_scale = 50.0;
        ASSERT_NEAR(state.q[0], z[0], kOscillatorRounding * p_scale / omega) << x << ' ' << k;
        ASSERT_NEAR(state.p[0], z[1], kOscillatorRounding * p_scale) << x << ' ' << k;
      });
    }
}

TEST(Verlet4, MassDampingTakesItsShareOfEachLinearModeExactly) {
  const double alpha = 4.0;
  for (const double x : {0.1, 1.0, 3.0}) {
    const auto integrator = make("verlet4", oscillator(x), oscillator_options(alpha));
    State from_q{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
    State from_p{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1)};
    testing::run(*integrator, from_q, {}, kOscillatorStep, 1);
    testing::run(*integrator, from_p, {}, kOscillatorStep, 1);
    const double area = from_q.q[0] * from_p.p[0] - from_p.q[0] * from_q.p[0];
    EXPECT_NEAR(area, std::exp(-alpha * kOscillatorStep), kOscillatorRounding * 5.0) << x;
  }
}

TEST(Verlet4, DampingThatVanishesIsNoDamping) {
  State free{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Ones(1)}, damped = free;
  testing::run(*make("verlet4", oscillator(0.5), oscillator_options(0.0)), free, {},
               kOscillatorStep, 3);
  testing::run(*make("verlet4", oscillator(0.5), oscillator_options(1e-322)), damped, {},
               kOscillatorStep, 3);
  EXPECT_EQ(free.q, damped.q);
  EXPECT_EQ(free.p, damped.p);
}

// |H1 - H0 - work + dissipated| over 0.4 s of a strongly nonlinear, damped and loaded motion.
double imbalance(std::string_view name, int steps) {
  const auto strain = testing::strong_strain_model();
  const Eigen::Vector4d force(8.0, -20.0, 30.0, 50.0);
  IntegratorOptions options{.step = 0.4 / steps, .alpha = 0.9, .beta = 3e-3};
  options.tolerance = 1e-13;
  options.split = {.rule = SplitRule::kCount, .count = 2};
  const auto integrator = make(name, testing::make_model(strain), options);
  State state{Eigen::Vector4d(0.25, -0.15, 0.1, 0.05), Eigen::Vector4d(-0.6, 1.0, 0.7, -1.1)};
  const auto energy = [&] {
    return 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
  };
  double balance = -energy();
  StepLoad load = make_step_load(4);
  const std::vector<Load> loads = {{{.kind = SignalKind::kSine, .frequency = 1.3}, force}};
  for (int k = 0; k < steps; ++k) {
    sample_loads(loads, k * options.step, options.step, load);
    const Eigen::VectorXd before = state.q;
    const StepReport report = integrator->step(state, load);
    EXPECT_TRUE(report.converged);
    balance += report.dissipated - report.extra_work - load.average.dot(state.q - before);
  }
  return std::abs(balance + energy());
}

TEST(EnergyBalance, OfLoadAndDampingClosesToTheOrderOfTheMethod) {
  for (const char* name : {"explicit-euler", "implicit-euler", "rk2", "rk4", "verlet4",
                           "imexv-linear", "imexv-coupled"}) {
    const int order = testing::order_of(name);
    const int steps = order == 1 ? 6400 : order == 2 ? 800 : name[0] == 'r' ? 800 : 100;
    // The next term is up to a tenth of the leading one.
    EXPECT_NEAR(std::log2(imbalance(name, steps) / imbalance(name, 2 * steps)), order, 0.2) << name;
  }
}

}  // namespace
}  // namespace tremolo
