// Each method on linear oscillators against its own recurrence, worked out by hand.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;

testing::StrainModel oscillators(const std::vector<double>& step_omegas) {
  Eigen::VectorXd omega(step_omegas.size());
  for (std::size_t i = 0; i < step_omegas.size(); ++i) omega[i] = step_omegas[i] / kOscillatorStep;
  return testing::random_strain_model(omega, 0.0, 1);
}

// q_n = q0 cos(n theta) + (p0/w) sin(n theta), and p_n = p0 cos(n theta) - q0 w sin(n theta).
void expect_rotation(std::string_view name, const IntegratorOptions& options, double omega,
                     double theta, double w) {
  const Model::Pointer model = testing::make_model(oscillators({kOscillatorStep * omega}));
  const auto integrator = make(name, model, options);
  const double q0 = 0.3, p0 = 0.7 * omega;
  State state{Eigen::VectorXd::Constant(1, q0), Eigen::VectorXd::Constant(1, p0)};
  for (int n = 1; n <= 50; ++n) {
    testing::run(*integrator, state, {}, kOscillatorStep, 1);
    const double c = std::cos(n * theta), s = std::sin(n * theta);
    // theta itself is rounded: n times that, and 1/w grows towards the limit of stability.
    const double q_size = q0 + p0 / w, p_size = p0 + q0 * w;
    EXPECT_NEAR(state.q[0], q0 * c + p0 / w * s, kOscillatorRounding * q_size) << name << ' ' << n;
    EXPECT_NEAR(state.p[0], p0 * c - q0 * w * s, kOscillatorRounding * p_size) << name << ' ' << n;
  }
}

TEST(Recurrence, VerletTurnsByItsClosedFormAngle) {
  for (const double x : {0.1, 0.5, 1.0, 1.5, 1.9}) {
    const double theta = std::acos(1.0 - 0.5 * x * x);
    expect_rotation("verlet", oscillator_options(), x / kOscillatorStep, theta,
                    std::sin(theta) / kOscillatorStep);
    IntegratorOptions explicit_newmark = oscillator_options();
    explicit_newmark.newmark_beta = 0.0;
    expect_rotation("newmark", explicit_newmark, x / kOscillatorStep, theta,
                    std::sin(theta) / kOscillatorStep);
  }
}

TEST(Recurrence, MidpointAndNewmarkTurnByTwiceTheArcTangent) {
  for (const double x : {0.1, 1.0, 2.0, 5.0, 50.0}) {
    const double theta = 2.0 * std::atan(0.5 * x);
    expect_rotation("midpoint", oscillator_options(), x / kOscillatorStep, theta,
                    x / kOscillatorStep);
    // Newmark's equation holds at the end of the step: its terms cancel to 1/(h omega)^2 of their
    // size, which at 50 leaves three digits less.
    if (x < 10.0)
      expect_rotation("newmark", oscillator_options(), x / kOscillatorStep, theta,
                      x / kOscillatorStep);
  }
}

TEST(Recurrence, SplittingMethodsTurnLowRowsLikeVerletAndHighRowsLikeMidpoint) {
  const double low = 1.2, high = 7.0;
  const double low_angle = std::acos(1.0 - 0.5 * low * low);
  for (const char* name : {"imexv", "imexv-linear", "imexv-coupled"}) {
    expect_rotation(name, oscillator_options(), low / kOscillatorStep, low_angle,
                    std::sin(low_angle) / kOscillatorStep);
    expect_rotation(name, oscillator_options(), high / kOscillatorStep, 2.0 * std::atan(0.5 * high),
                    high / kOscillatorStep);
  }
}

// One coordinate of a damped, forced step, and the state saved for the next one.
struct Scalar {
  double q, p;
  double load_before = 0.0;
};
struct StepForces {
  double start, average, end;
};

// Half a step of p' = -D p + f, exactly.
double damped_kick(double p, double force, double rate) {
  const double decay = std::exp(-0.5 * kOscillatorStep * rate);
  return decay * p + (1.0 - decay) / rate * force;
}

Scalar verlet_step(Scalar s, StepForces f, double lambda, double rate) {
  s.p = damped_kick(s.p, f.start - lambda * s.q, rate);
  s.q += kOscillatorStep * s.p;
  s.p = damped_kick(s.p, f.end - lambda * s.q, rate);
  return s;
}

Scalar midpoint_step(Scalar s, StepForces f, double lambda, double rate) {
  const double h = kOscillatorStep;
  const double d = (h * s.p + 0.5 * h * h * (f.average - lambda * s.q)) /
                   (1.0 + 0.25 * h * h * lambda + 0.5 * h * rate);
  return {s.q + d, 2.0 * d / h - s.p};
}

// imexv and imexv-linear where the damping may depend on q, and the coupled split: undamped kicks,
// and between them a drift that the midpoint rule damps.
Scalar damped_drift_step(Scalar s, StepForces f, double lambda, double rate) {
  s.p += 0.5 * kOscillatorStep * (f.start - lambda * s.q);
  s = midpoint_step(s, {0.0, 0.0, 0.0}, 0.0, rate);
  s.p += 0.5 * kOscillatorStep * (f.end - lambda * s.q);
  return s;
}

Scalar newmark_step(Scalar s, StepForces f, double lambda, double rate, double beta, double gamma) {
  const double h = kOscillatorStep;
  const double a0 = f.start - rate * s.p - lambda * s.q;
  const double q = s.q + h * s.p + h * h * (0.5 - beta) * a0;
  const double p = s.p + h * (1.0 - gamma) * a0;
  const double a1 =
      (f.end - rate * p - lambda * q) / (1.0 + gamma * h * rate + beta * h * h * lambda);
  return {q + beta * h * h * a1, p + gamma * h * a1};
}

// The midpoint rule with theta of runtime/bodies/reduced/integrators/solve/damping.h, from the
// roots e^{-c/2 +- i psi}, tan(psi/2) = (w^2 - c^2/4)^{1/2}/2: below critical damping.
Scalar imexv_high_step(Scalar s, StepForces f, double lambda, double rate) {
  const double h = kOscillatorStep, c = h * rate, w2 = h * h * lambda;
  const double psi = 2.0 * std::atan(0.5 * std::sqrt(w2 - 0.25 * c * c));
  const double product = 1.0 + std::exp(-c) - 2.0 * std::exp(-0.5 * c) * std::cos(psi);
  const double sigma = 0.5 + (1.0 - std::exp(-c)) / product - c / w2;
  // sigma Dp = d/h - p, Dp/h + lambda (q + d/2) + rate d/h = f
  const double d = (s.p / h + sigma * (f.average - lambda * s.q)) /
                   (1.0 / (h * h) + sigma * (0.5 * lambda + rate / h));
  return {s.q + d, s.p + (d / h - s.p) / sigma};
}

// If the damping may depend on q all of it is between the kicks.
Scalar linear_high_step(Scalar s, StepForces f, double lambda, double rate) {
  s.p += 0.5 * kOscillatorStep * f.start;
  s = midpoint_step(s, {0.0, 0.0, 0.0}, lambda, rate);
  s.p += 0.5 * kOscillatorStep * f.end;
  return s;
}

Scalar thesis_low_step(Scalar s, StepForces f, double lambda, double rate) {
  s.p += kOscillatorStep * (0.5 * (s.load_before + f.start) - lambda * s.q - rate * s.p);
  return {s.q + kOscillatorStep * s.p, s.p, f.end};
}

Scalar thesis_high_step(Scalar s, StepForces f, double lambda, double rate) {
  const double h = kOscillatorStep;
  // d - h p + (h^2/2)(lambda (q + d/2) + rate (2 d/h - p) - f) = 0
  const double d = (h * s.p + 0.5 * h * h * (f.average - lambda * s.q + rate * s.p)) /
                   (1.0 + 0.25 * h * h * lambda + h * rate);
  return {s.q + d, 2.0 * d / h - s.p};
}

using ScalarStep = std::function<Scalar(Scalar, StepForces)>;

// Sixty steps of two uncoupled oscillators, the first low and the second high, under a load whose
// three values differ, against the two scalar recurrences.
void expect_recurrence(std::string_view name, IntegratorOptions options,
                       const std::vector<double>& step_omegas, const ScalarStep& first,
                       const ScalarStep& second) {
  options.split = {.rule = SplitRule::kCount, .count = 1};
  const Model::Pointer model = testing::make_model(oscillators(step_omegas));
  const auto integrator = make(name, model, options);
  State state{Eigen::Vector2d(0.02, -0.01), Eigen::Vector2d(3.0, 5.0)};
  Scalar low{state.q[0], state.p[0]}, high{state.q[1], state.p[1]};
  StepLoad load = make_step_load(2);
  for (unsigned k = 0; k < 60; ++k) {
    testing::randomize(load, 300.0, 3 * k);
    ASSERT_TRUE(integrator->step(state, load).converged);
    low = first(low, {load.start[0], load.average[0], load.end[0]});
    high = second(high, {load.start[1], load.average[1], load.end[1]});
    const double q_scale = 0.1, p_scale = 10.0;  // sizes of this motion
    EXPECT_NEAR(state.q[0], low.q, kOscillatorRounding * q_scale) << name << ' ' << k;
    EXPECT_NEAR(state.q[1], high.q, kOscillatorRounding * q_scale) << name << ' ' << k;
    EXPECT_NEAR(state.p[0], low.p, kOscillatorRounding * p_scale) << name << ' ' << k;
    EXPECT_NEAR(state.p[1], high.p, kOscillatorRounding * p_scale) << name << ' ' << k;
  }
}

constexpr double kAlpha = 0.7, kBeta = 2e-4;

double lambda_of(double step_omega) {
  return step_omega * step_omega / (kOscillatorStep * kOscillatorStep);
}
double rate_of(double step_omega) {
  return kAlpha + kBeta * lambda_of(step_omega);
}

TEST(Recurrence, VerletDampedAndForced) {
  const auto step = [](double x) {
    return [x](Scalar s, StepForces f) { return verlet_step(s, f, lambda_of(x), rate_of(x)); };
  };
  expect_recurrence("verlet", oscillator_options(kAlpha, kBeta), {0.5, 1.7}, step(0.5), step(1.7));
}

TEST(Recurrence, MidpointDampedAndForced) {
  const auto step = [](double x) {
    return [x](Scalar s, StepForces f) { return midpoint_step(s, f, lambda_of(x), rate_of(x)); };
  };
  expect_recurrence("midpoint", oscillator_options(kAlpha, kBeta), {0.5, 6.0}, step(0.5),
                    step(6.0));
}

TEST(Recurrence, NewmarkDampedAndForcedForSeveralPairs) {
  for (const auto& [beta, gamma] : {std::pair{0.25, 0.5}, {0.3025, 0.6}, {0.0, 0.5}, {0.1, 0.5}}) {
    const auto step = [beta = beta, gamma = gamma](double x) {
      return [=](Scalar s, StepForces f) {
        return newmark_step(s, f, lambda_of(x), rate_of(x), beta, gamma);
      };
    };
    IntegratorOptions options = oscillator_options(kAlpha, kBeta);
    options.newmark_beta = beta;
    options.newmark_gamma = gamma;
    expect_recurrence("newmark", options, {0.5, 1.7}, step(0.5), step(1.7));
  }
}

TEST(Recurrence, ImexvAndTheCoupledSplitDampedAndForced) {
  // At 6 h beta omega^2 is 0.7: theta has no effect. At 2 it is 0.08: theta has all of it.
  for (const double x : {6.0, 2.0})
    for (const char* name : {"imexv", "imexv-coupled"})
      expect_recurrence(
          name, oscillator_options(kAlpha, kBeta), {0.5, x},
          [](Scalar s, StepForces f) {
            return damped_drift_step(s, f, lambda_of(0.5), rate_of(0.5));
          },
          [x](Scalar s, StepForces f) {
            return x == 6.0 ? midpoint_step(s, f, lambda_of(x), rate_of(x))
                            : imexv_high_step(s, f, lambda_of(x), rate_of(x));
          });
}

TEST(Recurrence, LinearSplitDampedAndForced) {
  expect_recurrence(
      "imexv-linear", oscillator_options(kAlpha, kBeta), {0.5, 6.0},
      [](Scalar s, StepForces f) { return damped_drift_step(s, f, lambda_of(0.5), rate_of(0.5)); },
      [](Scalar s, StepForces f) { return linear_high_step(s, f, lambda_of(6.0), rate_of(6.0)); });
}

TEST(Recurrence, ImexvThesisDampedAndForced) {
  expect_recurrence(
      "imexv-thesis", oscillator_options(kAlpha, kBeta), {0.5, 6.0},
      [](Scalar s, StepForces f) { return thesis_low_step(s, f, lambda_of(0.5), rate_of(0.5)); },
      [](Scalar s, StepForces f) { return thesis_high_step(s, f, lambda_of(6.0), rate_of(6.0)); });
}

// The area of the phase plane that one step of a linear mode keeps: the determinant of its map.
double area_factor(std::string_view name, double step_omega, double alpha) {
  const Model::Pointer model = testing::make_model(oscillators({step_omega}));
  const auto integrator = make(name, model, oscillator_options(alpha));
  State from_q{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Zero(1)};
  State from_p{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1)};
  testing::run(*integrator, from_q, {}, kOscillatorStep, 1);
  testing::run(*integrator, from_p, {}, kOscillatorStep, 1);
  return from_q.q[0] * from_p.p[0] - from_p.q[0] * from_q.p[0];
}

TEST(Recurrence, DampingDecaysExplicitModesExactlyAndImplicitOnesNearly) {
  const double alpha = 4.0;
  for (const double x : {0.1, 1.0, 1.7, 1.9, 3.0, 30.0})
    for (const char* name : {"verlet", "imexv", "imexv-linear", "imexv-coupled"}) {
      const bool is_verlet = std::string_view(name) == "verlet";
      if (is_verlet && x > 2.0) continue;
      // Implicit rows, from x = 1.8, keep the midpoint rule's inertia: off by O(c^2), c = 0.04. The
      // coupled split's drift takes the midpoint rule: off by c^3/12.
      const bool is_coupled = std::string_view(name) == "imexv-coupled";
      const double bound = (x < 1.8 || is_verlet) && !is_coupled ? kOscillatorRounding : 1e-5;
      EXPECT_NEAR(area_factor(name, x, alpha), std::exp(-alpha * kOscillatorStep), bound)
          << name << x;
    }
  // The midpoint rule takes alpha as part of D and underdamps fast modes.
  EXPECT_GT(area_factor("midpoint", 30.0, alpha), std::exp(-0.1 * alpha * kOscillatorStep));
}

TEST(NewmarkGuess, SolvesALinearEquationAndSavesCorrectionsInANonlinearOne) {
  // After one step the last factor is that of the linear equation itself: nothing is left to do.
  IntegratorOptions options{.step = kOscillatorStep, .alpha = 0.3, .beta = 1e-4};
  const auto linear =
      make("newmark", testing::make_model(oscillators({0.1, 0.7, 2.0, 9.0})), options);
  State state{testing::random_vector(4, 0.1, 1), testing::random_vector(4, 10.0, 2)};
  StepLoad load = make_step_load(4);
  load.start = load.average = load.end = testing::random_vector(4, 5.0, 3);
  load.active = true;
  for (int k = 0; k < 20; ++k) {
    const StepReport report = linear->step(state, load);
    ASSERT_TRUE(report.converged);
    if (k > 0) {
      EXPECT_EQ(report.iterations, 0) << k;
    }
  }
  const Model::Pointer model = testing::make_model(
      testing::random_strain_model(testing::spread_omega(6, 10.0, 200.0), 0.3, 4));
  const auto warm = make("newmark", model, options);
  State moving{testing::random_vector(6, 0.05, 5), testing::random_vector(6, 1.0, 6)};
  int with = 0, without = 0;
  for (int k = 0; k < 100; ++k) {
    State copy = moving;
    without += make("newmark", model, options)->step(copy, make_step_load(6)).iterations;
    with += warm->step(moving, make_step_load(6)).iterations;
    // The same step to the tolerance.
    EXPECT_LE((moving.q - copy.q).norm(), 1e-5 * (moving.q.norm() + copy.q.norm()));
  }
  EXPECT_LT(with, 0.8 * without);
}

}  // namespace
}  // namespace tremolo
