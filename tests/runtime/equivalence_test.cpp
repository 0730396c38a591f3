// Cases in which two methods are the same method, and the handling of a failed step.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/newton.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using testing::make;

testing::StrainModel five_coordinates() {
  return testing::random_strain_model(testing::spread_omega(5, 5.0, 400.0), 0.6, 33);
}

State five_moving() {
  return {testing::random_vector(5, 0.05, 1), testing::random_vector(5, 0.8, 2)};
}

IntegratorOptions split_options(double step, int low) {
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = low};
  options.tolerance = 1e-13;
  return options;
}

// A pulse that ends inside a step, and a sine.
std::vector<Load> loads_of() {
  return {{{.kind = SignalKind::kSquare, .duration = 0.0505}, testing::random_vector(5, 8.0, 3)},
          {{.kind = SignalKind::kSine, .frequency = 3.0}, testing::random_vector(5, 4.0, 4)}};
}

double distance(const State& a, const State& b) {
  return (a.q - b.q).norm() + (a.p - b.p).norm() / 100.0;
}

TEST(Equivalence, SplittingMethodsWithAllRowsLowAreVerlet) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const IntegratorOptions options = split_options(2e-3, 5);
  State b = five_moving();
  testing::run(*make("verlet", model, options), b, loads_of(), options.step, 200);
  for (const std::string_view name : {"imexv", "imexv-linear", "imexv-coupled"}) {
    State a = five_moving();
    testing::run(*make(name, model, options), a, loads_of(), options.step, 200);
    EXPECT_LE(distance(a, b), 1e-12) << name;  // the same operations
  }
}

TEST(Equivalence, SplitsThatSolveForEveryForceAreMidpointWithAllRowsHigh) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const IntegratorOptions options = split_options(5e-3, 0);
  State b = five_moving();
  testing::run(*make("midpoint", model, options), b, loads_of(), options.step, 100);
  for (const char* name : {"imexv", "imexv-coupled"}) {
    State a = five_moving();
    testing::run(*make(name, model, options), a, loads_of(), options.step, 100);
    // The same equation solved to 1e-13 a step, over 100 steps of a nonlinear motion.
    EXPECT_LE(distance(a, b), 1e-10) << name;
  }
}

TEST(Equivalence, DampedSplitsWithAllRowsHighAgree) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  IntegratorOptions options = split_options(5e-3, 0);
  options.alpha = 0.5;
  options.beta = 1e-4;
  State b = five_moving();
  testing::run(*make("imexv", model, options), b, loads_of(), options.step, 200);
  State a = five_moving();
  testing::run(*make("imexv-coupled", model, options), a, loads_of(), options.step, 200);
  EXPECT_LE(distance(a, b), 1e-10);
}

TEST(Equivalence, ExplicitNewmarkIsVerlet) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  IntegratorOptions options = split_options(2e-3, 5);
  options.newmark_beta = 0.0;
  State a = five_moving(), b = five_moving();
  testing::run(*make("newmark", model, options), a, loads_of(), options.step, 200);
  testing::run(*make("verlet", model, options), b, loads_of(), options.step, 200);
  EXPECT_LE(distance(a, b), 1e-11);  // rounding over 200 steps
}

TEST(Equivalence, ThesisFormHasTheOrbitOfImexvWhenItStartsHalfAKickBack) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const IntegratorOptions options = split_options(5e-3, 3);
  const auto symmetric = make("imexv", model, options);
  const auto thesis = make("imexv-thesis", model, options);
  State a = five_moving(), b = five_moving();
  Eigen::VectorXd momentum = b.p;
  thesis->synchronized_momentum(b, momentum);
  b.p -= momentum - b.p;
  StepLoad load = make_step_load(5);
  for (int k = 0; k < 150; ++k) {
    sample_loads(loads_of(), k * options.step, options.step, load);
    ASSERT_TRUE(symmetric->step(a, load).converged);
    ASSERT_TRUE(thesis->step(b, load).converged);
    thesis->synchronized_momentum(b, momentum);
    // Equal up to rounding and the solves' tolerance, amplified over 150 steps.
    ASSERT_LE((a.q - b.q).norm(), 1e-9) << k;
    ASSERT_LE((a.p - momentum).norm(), 1e-7) << k;
  }
  EXPECT_GE((a.p - b.p).norm(), 1e-3) << "the stored momentum should lag";
}

TEST(Equivalence, ChangingTheStateFromOutsideIsNoticed) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names()) {
    const IntegratorOptions options = split_options(2e-3, 3);
    const auto used = make(name, model, options);
    State warm{testing::random_vector(5, 0.05, 8), testing::random_vector(5, 0.5, 9)};
    testing::run(*used, warm, {}, options.step, 3);
    State a = five_moving(), b = five_moving();
    testing::run(*used, a, {}, options.step, 5);
    testing::run(*make(name, model, options), b, {}, options.step, 5);
    EXPECT_EQ(a.q, b.q) << name;
    EXPECT_EQ(a.p, b.p) << name;
  }
}

TEST(Failure, SolveThatGivesUpRestoresTheStateAndSaysSo) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  IntegratorOptions options = split_options(2e-2, 2);
  options.max_iterations = 1;  // far too few for this state
  options.halvings = 0;
  const State before{testing::random_vector(5, 0.6, 5), testing::random_vector(5, 60.0, 6)};
  for (const char* name :
       {"midpoint", "newmark", "imexv", "imexv-thesis", "imexv-coupled", "implicit-euler"}) {
    State state = before;
    const StepReport report = make(name, model, options)->step(state, make_step_load(5));
    EXPECT_FALSE(report.converged) << name;
    EXPECT_EQ(report.iterations, 1) << name;
    EXPECT_GT(report.residual, 0.0) << name;
    EXPECT_EQ(state.q, before.q) << name;
    EXPECT_EQ(state.p, before.p) << name;
  }
}

TEST(Failure, FailedStepLeavesNoTraceInTheNextOne) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const IntegratorOptions options = split_options(2e-3, 3);
  for (const std::string_view name : integrator_names()) {
    const auto integrator = make(name, model, options);
    State a = five_moving(), b = five_moving();
    testing::run(*integrator, a, {}, options.step, 2);
    StepLoad broken = make_step_load(5);
    broken.start.setConstant(std::nan(""));
    broken.average = broken.end = broken.start;
    EXPECT_FALSE(integrator->step(a, broken).converged) << name;
    testing::run(*integrator, a, {}, options.step, 2);
    testing::run(*make(name, model, options), b, {}, options.step, 4);
    EXPECT_EQ(a.q, b.q) << name;
    EXPECT_EQ(a.p, b.p) << name;
  }
}

TEST(Failure, NumbersThatOverflowAreNoConvergence) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names()) {
    const State before{Eigen::VectorXd::Constant(5, 1e150), Eigen::VectorXd::Zero(5)};
    State state = before;
    EXPECT_FALSE(
        make(name, model, split_options(2e-3, 3))->step(state, make_step_load(5)).converged)
        << name;
    EXPECT_EQ(state.q, before.q) << name;
    EXPECT_EQ(state.p, before.p) << name;
  }
}

TEST(Rest, BodyAtRestStaysThereWithoutASolve) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names()) {
    State state{Eigen::VectorXd::Zero(5), Eigen::VectorXd::Zero(5)};
    const StepReport report =
        make(name, model, split_options(2e-3, 3))->step(state, make_step_load(5));
    EXPECT_TRUE(report.converged) << name;
    EXPECT_EQ(report.iterations, 0) << name;
    EXPECT_EQ(state.q, Eigen::VectorXd::Zero(5)) << name;
  }
}

TEST(Rest, MotionThatHasAllButDiedOutStillConverges) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names())
    for (const double size : {1e-80, 1e-140, 1e-200, 1e-300}) {
      State state{Eigen::VectorXd::Constant(5, size), Eigen::VectorXd::Constant(5, size)};
      testing::run(*make(name, model, split_options(2e-3, 3)), state, {}, 2e-3, 20);
    }
}

TEST(Rest, DampedMotionPassesThroughTheSmallestNumbersToRest) {
  // Squares vanish below 1e-162, and with them norms, before the numbers themselves do.
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names())
    for (int exponent = 145; exponent < 325; ++exponent) {
      IntegratorOptions options = split_options(2e-3, 3);
      options.alpha = 30.0;
      options.beta = 1e-4;
      const double size = std::pow(10.0, -exponent);
      State state{testing::random_vector(5, size, 1), testing::random_vector(5, 100.0 * size, 2)};
      testing::run(*make(name, model, options), state, {}, 2e-3, 20);
      EXPECT_LE(state.q.cwiseAbs().maxCoeff(), 100.0 * size) << name << ", 1e-" << exponent;
    }
}

TEST(Step, SmallMotionKeepsItsEnergyAtAnyStep) {
  // h omega from 1e-8 to 1e6, one and two coordinates.
  for (const Eigen::Index r : {1, 2})
    for (double x = 1e-8; x < 2e6; x *= 10.0) {
      constexpr double kStep = 3e-3;
      const testing::StrainModel strain = testing::random_strain_model(
          testing::spread_omega(r, 0.1 * x / kStep, x / kStep), 0.1, 9);
      const Model::Pointer model = testing::make_model(strain);
      for (const char* name : {"midpoint", "newmark", "imexv", "imexv-adaptive", "imexv-linear",
                               "imexv-coupled", "avf", "ep2", "ep4", "implicit-euler"})
        for (const double alpha : {0.0, 5.0}) {
          // Newmark's solve starts from the old acceleration, (h omega)^2/2 amplitudes too far out.
          if (std::string_view(name) == "newmark" && x > 2e4) continue;
          const auto integrator = make(name, model, {.step = kStep, .alpha = alpha});
          // Small motion: a row gets as far as its period or the step lets it.
          const double size = 1e-4 * std::min(1.0, 1.0 / x);
          State state{size * Eigen::VectorXd::Ones(r), size * x / kStep * Eigen::VectorXd::Ones(r)};
          const auto energy = [&] {
            return 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
          };
          const double before = energy();
          testing::run(*integrator, state, {}, kStep, 20);
          // The explicit rows oscillate about a level up to 1/(1 - 0.9^2) times as high.
          EXPECT_LE(energy(), 6.0 * before) << name << ", " << x << ", " << r << ", " << alpha;
        }
    }
}

TEST(Newton, StiffCoordinatesConvergeToTheirRounding) {
  // h omega = 3e4: the residual cannot be rounded to better than 1e9 * 2e-16 of the step, which is
  // above the default tolerance.
  const Model::Pointer model =
      testing::make_model(testing::random_strain_model(Eigen::Vector2d(1e2, 1e7), 0.0, 3));
  for (const char* name :
       {"midpoint", "newmark", "imexv", "imexv-linear", "imexv-coupled", "implicit-euler"}) {
    State state{Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(3.0, 4.0)};
    testing::run(*make(name, model, {}), state, {}, 3e-3, 200);
  }
}

TEST(Newton, IndefiniteJacobianIsShiftedUntilTheCorrectionLeadsDownhill) {
  NewtonWorkspace workspace(4);
  const Eigen::MatrixXd random = testing::random_vector(16, 1.0, 1).reshaped(4, 4);
  const Eigen::MatrixXd matrix =
      random + random.transpose() - 0.5 * Eigen::MatrixXd::Identity(4, 4);
  workspace.jacobian = matrix;
  ASSERT_LT(matrix.eigenvalues().real().minCoeff(), 0.0);
  workspace.residual = testing::random_vector(4, 1.0, 2);
  ASSERT_TRUE(factor_jacobian(workspace));
  EXPECT_GT(workspace.shift, 0.0);
  solve_correction(workspace);
  EXPECT_GT(workspace.correction.dot(workspace.residual), 0.0);
  const Eigen::MatrixXd shifted = matrix + workspace.shift * Eigen::MatrixXd::Identity(4, 4);
  EXPECT_LE((shifted * workspace.correction - workspace.residual).norm(), 1e-12);  // rounding
}

TEST(Newton, LineSearchFindsTheFirstZeroOfACubic) {
  // s(t) = (t - 0.3)(t - 2)(t + 1), negative at 0 upside down: -s.
  const auto s = [](double t) { return -(t - 0.3) * (t - 2.0) * (t + 1.0) - 0.0; };
  const auto slope = [&](double t) { return (s(t + 1e-6) - s(t - 1e-6)) / 2e-6; };
  ASSERT_LT(s(0.0), 0.0);
  for (const double end : {0.1, 1.0})
    EXPECT_NEAR(first_zero(end, s(0.0), slope(0.0), s(end), slope(end)), 0.3, 1e-6) << end;
  EXPECT_EQ(first_zero(1.0, -1.0, 0.0, -1.0, 0.0), 4.0) << "no zero: as far as one may go";
}

TEST(Newton, QuarticWellIsSolvedFromFarAway) {
  // g(x) = x^3 - 1 - 5 x, the gradient of a double well: Newton alone jumps about from x = 1.3,
  // where the curvature nearly vanishes.
  for (const double start : {1.3, 1.2909, -40.0, 1e5}) {
    NewtonWorkspace workspace(1);
    workspace.unknowns[0] = start;
    const StepReport report = solve_newton(workspace, 40, [&] {
      const double x = workspace.unknowns[0];
      workspace.residual[0] = x * x * x - 5.0 * x - 1.0;
      workspace.jacobian(0, 0) = 3.0 * x * x - 5.0;
      return std::abs(workspace.residual[0]) / 1e-10;
    });
    EXPECT_TRUE(report.converged) << start;
  }
}

TEST(Factory, UnknownNameIsAUsageErrorThatListsTheKnownOnes) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const auto unknown = make_integrator("leapfrog", model, {});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::kUsage);
  for (const std::string_view name : integrator_names())
    EXPECT_NE(unknown.error().message.find(name), std::string::npos) << name;
}

TEST(Factory, EveryNameMakesAMethodOfThatName) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  for (const std::string_view name : integrator_names()) {
    const auto integrator = make(name, model, {});
    EXPECT_EQ(integrator->name(), name);
    EXPECT_EQ(integrator->split().has_value(), name.starts_with("imexv"));
  }
}

TEST(Factory, ThesisFormUsesTheDefaultSplitUnlessToldOtherwise) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const Split by_default = *choose_split(model->lambda(), 3e-3, {});
  EXPECT_EQ(make("imexv-thesis", model, {})->split()->low, by_default.low);
  EXPECT_EQ(make("imexv-thesis", model, split_options(3e-3, 1))->split()->low, 1);
}

TEST(Factory, RefusesOptionsOutsideTheirRange) {
  const Model::Pointer model = testing::make_model(five_coordinates());
  const auto refuses = [&](auto change) {
    IntegratorOptions options;
    change(options);
    const auto made = make_integrator("newmark", model, options);
    return !made && made.error().kind == ErrorKind::kUsage;
  };
  EXPECT_TRUE(refuses([](auto& o) { o.step = 0.0; }));
  EXPECT_TRUE(refuses([](auto& o) { o.step = std::nan(""); }));
  EXPECT_TRUE(refuses([](auto& o) { o.alpha = -1.0; }));
  EXPECT_TRUE(refuses([](auto& o) { o.beta = INFINITY; }));
  EXPECT_TRUE(refuses([](auto& o) { o.newmark_beta = -0.1; }));
  EXPECT_TRUE(refuses([](auto& o) { o.newmark_gamma = std::nan(""); }));
  EXPECT_TRUE(refuses([](auto& o) { o.tolerance = 0.0; }));
  EXPECT_TRUE(refuses([](auto& o) { o.max_iterations = 0; }));
}

}  // namespace
}  // namespace tremolo
