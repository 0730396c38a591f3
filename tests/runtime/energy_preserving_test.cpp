// avf, ep2 and ep4: the energy balance of each step, order, frequency and decay of linear modes.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;

constexpr const char* kFamily[] = {"avf", "ep2", "ep4"};

double energy_of(const testing::StrainModel& strain, const State& state) {
  return 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
}

// The largest |H1 - H0 - work + dissipated| of any step, over the largest H. The steps know V as
// the model's polynomial, whose rounding at both ends of a step is measured and taken off.
double worst_balance(std::string_view name, const IntegratorOptions& options, double size,
                     bool loaded, int steps) {
  const testing::StrainModel strain = strong_strain_model();
  const Model::Pointer model = testing::make_model(strain);
  const auto integrator = make(name, model, options);
  PotentialWorkspace workspace = model->potential().make_workspace(kUseTangent);
  Evaluation at_end = model->potential().make_evaluation();
  State state{size * strong_state().q, size * strong_state().p};
  std::vector<Load> loads;
  if (loaded)
    loads = {{{.kind = SignalKind::kSine, .frequency = 1.3}, kStrongForce},
             {{.kind = SignalKind::kSquare, .start = 0.1, .duration = 0.11}, -kStrongForce}};
  StepLoad load = make_step_load(4);
  double worst = 0.0, highest = 0.0, rounding = 0.0;
  for (int k = 0; k < steps; ++k) {
    sample_loads(loads, k * options.step, options.step, load);
    const State before = state;
    const StepReport report = integrator->step(state, load);
    EXPECT_TRUE(report.converged) << name << " at step " << k;
    const double change = energy_of(strain, state) - energy_of(strain, before);
    const double work = load.average.dot(state.q - before.q) + report.extra_work;
    worst = std::max(worst, std::abs(change - work + report.dissipated));
    highest = std::max(highest, energy_of(strain, state));
    // Each of the kernels' sums has its own.
    for (const unsigned want : {0U, kWantForce + 0U, kWantForce | kWantTangent}) {
      model->potential().evaluate(state.q, kWantEnergy | want, workspace, at_end);
      rounding =
          std::max(rounding, std::abs(at_end.energy - testing::strain_energy(strain, state.q)));
    }
    EXPECT_GE(report.dissipated, 0.0) << name;
  }
  EXPECT_LE(rounding, 1e-11 * highest) << "V of the model is not that of the strains";
  return std::max(0.0, worst - 2.0 * rounding) / highest;
}

// Rounding of energies that are sums of terms many times larger.
constexpr double kRoundedEnergy = 3e-13;

TEST(EnergyPreserving, EveryStepBalancesEnergyWorkAndDissipation) {
  for (const char* name : kFamily)
    for (const double step : {1e-3, 1e-2, 5e-2})
      for (const auto& [alpha, beta] :
           {std::pair{0.0, 0.0}, {0.9, 3e-3}, {0.0, 1e-4}, {200.0, 0.0}, {0.0, 1.0}, {2e4, 1.0}}) {
        IntegratorOptions options{.step = step, .alpha = alpha, .beta = beta};
        for (const bool loaded : {true, false})
          EXPECT_LE(worst_balance(name, options, 1.0, loaded, 400), kRoundedEnergy)
              << name << ", " << step << ", alpha " << alpha << ", beta " << beta;
      }
}

TEST(EnergyPreserving, BalanceHoldsWhateverTheTolerance) {
  for (const char* name : kFamily)
    for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-12}) {
      IntegratorOptions options{.step = 1e-2, .alpha = 0.3};
      options.tolerance = tolerance;
      EXPECT_LE(worst_balance(name, options, 1.0, true, 400), kRoundedEnergy)
          << name << ", " << tolerance;
    }
}

TEST(EnergyPreserving, BalanceHoldsWhereAStepEndsAlmostAtRest) {
  // Motion from rest, reversed, returns to rest: there is no momentum from which what the
  // solve left could be taken back.
  for (const char* name : kFamily) {
    const Model::Pointer model = testing::make_model(strong_strain_model());
    const auto integrator = make(name, model, {.step = 1e-2});
    const auto energy = [&](const State& s) { return energy_of(strong_strain_model(), s); };
    State state = strong_state();
    state.p.setZero();
    const double before = energy(state);
    double worst = 0.0, slowest = state.q.norm();
    for (int k = 0; k < 40; ++k) {
      if (k == 20) state.p = -state.p;
      testing::run(*integrator, state, {}, 1e-2, 1);
      worst = std::max(worst, std::abs(energy(state) - before) / before);
      if (k > 20) slowest = std::min(slowest, state.p.squaredNorm() / before);
    }
    EXPECT_LE(slowest, 1e-6) << name << ": the motion should have come to rest";
    EXPECT_LE(worst, kRoundedEnergy) << name;
  }
}

// avf has N = I, so that its equations can be checked by the mean force alone: at rest, where a
// step begins with d = 0, and in motion.
TEST(EnergyPreserving, AvfSolvesItsEquationsFromRestAndInMotion) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  const Potential& potential = model->potential();
  PotentialWorkspace workspace = potential.make_workspace();
  for (const double step : {1e-3, 1e-2, 3e-2}) {
    const auto integrator = make("avf", model, {.step = step, .tolerance = 1e-12});
    State state = strong_state();
    state.p.setZero();
    for (int k = 0; k < 60; ++k) {
      if (k == 30) state.p.setZero();
      const State before = state;
      testing::run(*integrator, state, {}, step, 1);
      Eigen::VectorXd G(4);
      potential.averaged_gradient(before.q, state.q, workspace, G);
      const Eigen::VectorXd change = state.p - before.p;
      EXPECT_LT((change + step * G).norm(), 1e-10 * step * G.norm()) << step << ", step " << k;
      EXPECT_LT((state.q - before.q - 0.5 * step * (before.p + state.p)).norm(),
                1e-10 * step * step * G.norm() + 1e-12 * step * state.p.norm())
          << step << ", step " << k;
    }
  }
}

TEST(EnergyPreserving, BalanceHoldsInViolentMotionAtLargeSteps) {
  for (const char* name : kFamily)
    for (const double size : {3.0, 10.0, 30.0}) {
      // Strong cancellation in V: rounding relative to H is larger here.
      EXPECT_LE(worst_balance(name, {.step = 5e-2}, size, false, 200), 1e-12)
          << name << ", " << size;
    }
}

TEST(EnergyPreserving, StepsThatAreTakenInPartsKeepTheBalance) {
  // Two iterations are too few for the whole step.
  for (const char* name : kFamily) {
    IntegratorOptions options{.step = 3e-2, .alpha = 0.2};
    options.max_iterations = 3;
    options.halvings = 8;
    EXPECT_LE(worst_balance(name, options, 1.5, true, 200), 1e-13) << name;
  }
}

// The reference is good to about 1e-12 (step 2.5e-5 s).
double error_of(std::string_view name, IntegratorOptions options, int steps, bool loaded) {
  constexpr double kDuration = 0.4;
  const auto force = [&](double t) {
    return Eigen::VectorXd(loaded ? std::sin(2.0 * M_PI * 1.3 * t) * kStrongForce
                                  : Eigen::Vector4d(Eigen::Vector4d::Zero()));
  };
  const State exact = testing::reference_orbit(strong_strain_model(), strong_state(), options.alpha,
                                               options.beta, force, kDuration, 16000);
  options.step = kDuration / steps;
  options.tolerance = 1e-13;
  const auto integrator = make(name, testing::make_model(strong_strain_model()), options);
  State state = strong_state();
  std::vector<Load> loads;
  if (loaded) loads = {{{.kind = SignalKind::kSine, .frequency = 1.3}, kStrongForce}};
  testing::run(*integrator, state, loads, options.step, steps);
  return (state.q - exact.q).norm() + (state.p - exact.p).norm() / 40.0;
}

TEST(EnergyPreserving, Ep4IsOfFourthOrderAlsoWithLoadAndDampingByTheMass) {
  for (const bool loaded : {false, true})
    for (const double alpha : {0.0, 0.9}) {
      const IntegratorOptions options{.alpha = alpha};
      const double order =
          std::log2(error_of("ep4", options, 100, loaded) / error_of("ep4", options, 200, loaded));
      EXPECT_NEAR(order, 4.0, 0.15) << (loaded ? "loaded, alpha " : "alpha ") << alpha;
    }
}

// Of second order, for the middle's velocity is the mean one; of ep2's error 0.066 without and 0.16
// with the load.
TEST(EnergyPreserving, Ep4IsOfSecondOrderAndNearWhereDampingDependsOnTheStrains) {
  for (const bool loaded : {false, true}) {
    const IntegratorOptions options{.alpha = 0.9, .beta = 3e-3};
    const double coarse = error_of("ep4", options, 100, loaded);
    EXPECT_NEAR(std::log2(coarse / error_of("ep4", options, 200, loaded)), 2.0, 0.15) << loaded;
    EXPECT_LT(coarse, 0.2 * error_of("ep2", options, 100, loaded)) << loaded;
  }
}

// One step of a free linear mode as a 2 x 2 matrix on (omega q, p).
Eigen::Matrix2d linear_map(std::string_view name, double omega, const IntegratorOptions& options) {
  const auto strain = testing::random_strain_model(Eigen::VectorXd::Constant(1, omega), 0.0, 1);
  const auto integrator = make(name, testing::make_model(strain), options);
  Eigen::Matrix2d map;
  for (int column = 0; column < 2; ++column) {
    State state{Eigen::VectorXd::Constant(1, column == 0 ? 1.0 / omega : 0.0),
                Eigen::VectorXd::Constant(1, column == 1 ? 1.0 : 0.0)};
    testing::run(*integrator, state, {}, options.step, 1);
    map.col(column) << omega * state.q[0], state.p[0];
  }
  return map;
}

// The larger of the two roots of s^2 + D s + omega^2 = 0 in its real part, times h.
double exact_log_root(double step_rate, double step_omega) {
  const double square = 0.25 * step_rate * step_rate - step_omega * step_omega;
  if (square < 0.0) return -0.5 * step_rate;
  return -step_omega * step_omega / (0.5 * step_rate + std::sqrt(square));
}

// ln of the larger modulus of the step's two roots.
double log_root(std::string_view name, double step_rate, double step_omega) {
  IntegratorOptions options{.step = 3e-3, .tolerance = 1e-14};
  options.alpha = step_rate / options.step;
  const Eigen::Matrix2d map = linear_map(name, step_omega / options.step, options);
  return std::log(map.eigenvalues().cwiseAbs().maxCoeff());
}

TEST(EnergyPreserving, DampedLinearModesHaveTheirExactRoots) {
  for (const char* name : kFamily)
    for (const double step_omega : {0.05, 0.3, 0.6, 1.0, 1.8, 2.4})
      for (const double step_rate : {1e-3, 0.05, 0.3, 1.0, 1.2, 2.4, 3.0, 30.0, 1000.0}) {
        // At a double root the rounding of the map enters by its square root.
        const double exact = exact_log_root(step_rate, step_omega);
        EXPECT_NEAR(log_root(name, step_rate, step_omega), exact, 1e-6 * std::abs(exact) + 1e-10)
            << name << ", h omega " << step_omega << ", h D " << step_rate;
      }
}

TEST(EnergyPreserving, FreeModesNeverDecaySlowerForMoreDampingBelowTheCritical) {
  for (const char* name : kFamily)
    for (const double step_omega : {0.3, 1.0, 2.4, 3.0, 4.0, 6.0, 10.0, 30.0, 100.0}) {
      double before = 1.0;  // the larger root
      for (int k = 0; k <= 60; ++k) {
        const double step_rate = 2.0 * step_omega * std::pow(10.0, 0.06 * (k - 60));
        const double root = std::exp(log_root(name, step_rate, step_omega));
        // A stiff mode is as good as gone below a tenth; there its root changes sign.
        EXPECT_LE(root, std::max(before + 1e-9, 0.1))
            << name << ", h omega " << step_omega << ", h D " << step_rate;
        before = root;
      }
    }
}

TEST(EnergyPreserving, Ep2TurnsLinearModesByTheirExactAngle) {
  for (const double omega : {10.0, 300.0, 790.0}) {  // h omega up to 2.37
    const IntegratorOptions options{.step = 3e-3, .tolerance = 1e-13};
    const double angle = std::acos(0.5 * linear_map("ep2", omega, options).trace());
    EXPECT_NEAR(angle, omega * options.step, 1e-10) << omega;
  }
}

TEST(EnergyPreserving, MotionReturnsWhenTheMomentaAreTurnedRound) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  for (const char* name : kFamily) {
    const IntegratorOptions options{.step = 3e-2, .tolerance = 1e-13};
    const auto integrator = make(name, model, options);
    State state = strong_state();
    testing::run(*integrator, state, {}, options.step, 50);
    EXPECT_GE((state.q - strong_state().q).norm(), 0.05) << name << " did not move";
    state.p = -state.p;
    testing::run(*integrator, state, {}, options.step, 50);
    // The solves' 1e-13, stretched by 100 steps of a strongly nonlinear motion at h omega = 1.2.
    // ep4 with its filter at the predicted midpoint misses by 0.08.
    EXPECT_LE((state.q - strong_state().q).norm(), 1e-7) << name;
  }
}

// The last correction of most steps of ep4 is not evaluated. It shows neither in the orbit nor in
// the balance.
TEST(EnergyPreserving, OrbitsOfManyCoordinatesAreThoseOfAStrictSolve) {
  const testing::StrainModel strain =
      testing::random_strain_model(testing::spread_omega(20, 5.0, 400.0), 0.3, 5);
  const Model::Pointer model = testing::make_model(strain);
  for (const double beta : {0.0, 3e-4})
    for (const double size : {0.01, 0.1}) {
      const auto orbit = [&](double tolerance) {
        const auto integrator =
            make("ep4", model, {.step = 2e-3, .beta = beta, .tolerance = tolerance});
        State state{testing::random_vector(20, size, 6), Eigen::VectorXd::Zero(20)};
        for (Eigen::Index i = 0; i < 20; ++i) state.q[i] *= 5.0 / std::sqrt(model->lambda()[i]);
        StepLoad load = make_step_load(20);
        double energy = energy_of(strain, state), highest = energy;
        for (int k = 0; k < 300; ++k) {
          const StepReport report = integrator->step(state, load);
          EXPECT_TRUE(report.converged);
          const double next = energy_of(strain, state);
          EXPECT_LE(std::abs(next - energy + report.dissipated), kRoundedEnergy * highest)
              << beta << ", " << size << ", " << tolerance << ", step " << k;
          energy = next;
        }
        return state;
      };
      const State usual = orbit(1e-6), strict = orbit(1e-12);
      EXPECT_LE((usual.q - strict.q).norm(), 2e-5 * strict.q.norm()) << beta << ", " << size;
      EXPECT_GT((usual.q - strict.q).norm(), 0.0) << "the tolerance has no effect";
    }
}

TEST(EnergyPreserving, AveragedJacobianIsTheDerivativeOfTheAveragedGradient) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  const Potential& potential = model->potential();
  PotentialWorkspace workspace = potential.make_workspace();
  const Eigen::VectorXd q0 = testing::random_vector(4, 0.4, 3);
  const Eigen::VectorXd q1 = testing::random_vector(4, 0.4, 4);
  Eigen::MatrixXd jacobian(4, 4);
  potential.averaged_jacobian(q0, q1, workspace, jacobian);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const auto difference = [&](double s) {
      Eigen::VectorXd up(4), down(4);
      potential.averaged_gradient(q0, q1 + s * Eigen::VectorXd::Unit(4, i), workspace, up);
      potential.averaged_gradient(q0, q1 - s * Eigen::VectorXd::Unit(4, i), workspace, down);
      return Eigen::VectorXd((up - down) / (2.0 * s));
    };
    // Cubic in q1: the extrapolated difference has no truncation error.
    const Eigen::VectorXd column = (4.0 * difference(0.1) - difference(0.2)) / 3.0;
    EXPECT_LE((column - jacobian.col(i)).norm(), 1e-12 * jacobian.norm()) << i;
  }
}

}  // namespace
}  // namespace tremolo
