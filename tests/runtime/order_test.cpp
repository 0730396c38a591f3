// Order, reversibility and symplecticity on a strongly nonlinear model.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/dispersion.h"
#include "tests/support/dynamics.h"
#include "tests/support/linear_model.h"

namespace tremolo {
namespace {

using namespace testing;

IntegratorOptions precise_options(double step) {
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = 2};
  options.tolerance = 1e-13;
  return options;
}

struct Setting {
  double alpha = 0.0;
  double beta = 0.0;
  bool loaded = false;
  double ratio = 0.0;  // of critical damping of each mode
};

constexpr double kFrequency = 1.3;  // Hz
constexpr double kDuration = 0.4;   // s

Eigen::VectorXd sine_load(double t) {
  return std::sin(2.0 * M_PI * kFrequency * t) * kStrongForce;
}

State reference(const Setting& setting) {
  const auto force = [&](double t) {
    return setting.loaded ? sine_load(t) : Eigen::VectorXd(Eigen::Vector4d::Zero());
  };
  // Step 2.5e-5 s: fourth order leaves an error near 1e-12.
  return testing::reference_orbit(strong_strain_model(), strong_state(), setting.alpha,
                                  setting.beta, force, kDuration, 16000, setting.ratio);
}

double error_of(std::string_view name, const Setting& setting, const State& exact, int steps) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  IntegratorOptions options = precise_options(kDuration / steps);
  options.alpha = setting.alpha;
  options.beta = setting.beta;
  if (setting.ratio > 0.0) options.ratios.of_modes = {setting.ratio};
  const auto integrator = make(name, model, options);
  State state = strong_state();
  Eigen::VectorXd momentum = state.p;
  if (name == "imexv-thesis") {
    // Its low momenta lag by half a kick; the load is zero at the start.
    integrator->synchronized_momentum(state, momentum);
    state.p -= momentum - state.p;
  }
  std::vector<Load> loads;
  if (setting.loaded)
    loads.push_back({{.kind = SignalKind::kSine, .frequency = kFrequency}, kStrongForce});
  testing::run(*integrator, state, loads, options.step, steps);
  integrator->synchronized_momentum(state, momentum);
  return (state.q - exact.q).norm() + (momentum - exact.p).norm() / 40.0;
}

// h small enough for the leading term of the error to rule, large enough for the error to stand
// above the reference's.
int steps_of(std::string_view name) {
  if (testing::order_of(name) == 1) return 6400;
  if (name == "rk4") return 1600;  // its next term is large
  return testing::order_of(name) == 4 ? 200 : 800;
}

// log2 of the ratio of errors at h and h/2.
double observed_order(std::string_view name, const Setting& setting) {
  const State exact = reference(setting);
  const int steps = steps_of(name);
  return std::log2(error_of(name, setting, exact, steps) /
                   error_of(name, setting, exact, 2 * steps));
}

// The term after the leading one is then some per cent of it.
constexpr double kOrder = 0.07;

TEST(Order, EveryMethodIsOfItsOrder) {
  for (const std::string_view name : integrator_names())
    EXPECT_NEAR(observed_order(name, {}), testing::order_of(name), kOrder) << name;
}

TEST(Order, EveryMethodIsOfItsOrderUnderASmoothLoad) {
  for (const std::string_view name : integrator_names())
    EXPECT_NEAR(observed_order(name, {.loaded = true}), testing::order_of(name), kOrder) << name;
}

TEST(Order, EveryMethodButTheThesisFormIsOfItsOrderAgainstDamping) {
  for (const std::string_view name : integrator_names())
    if (name != "imexv-thesis") {
      EXPECT_NEAR(observed_order(name, {.alpha = 0.9}), testing::order_of(name), kOrder) << name;
      EXPECT_NEAR(observed_order(name, {.alpha = 0.9, .beta = 3e-3}), testing::order_of(name, 3e-3),
                  kOrder)
          << name;
    }
}

// With beta in addition, which only the library allows.
TEST(Order, EveryMethodButTheThesisFormIsOfItsOrderAgainstARatioOfEachMode) {
  for (const std::string_view name : integrator_names())
    if (name != "imexv-thesis") {
      const int order = testing::order_of(name);
      EXPECT_NEAR(observed_order(name, {.ratio = 0.03}), order, kOrder) << name;
      EXPECT_NEAR(observed_order(name, {.loaded = true, .ratio = 0.03}), order, kOrder) << name;
      EXPECT_NEAR(observed_order(name, {.beta = 3e-3, .ratio = 0.03}),
                  testing::order_of(name, 3e-3), kOrder)
          << name;
    }
}

TEST(Order, EveryMethodButTheThesisFormIsOfItsOrderAgainstDampingAndLoad) {
  const Setting setting{.alpha = 0.9, .beta = 3e-3, .loaded = true};
  for (const std::string_view name : integrator_names())
    if (name != "imexv-thesis") {
      EXPECT_NEAR(observed_order(name, setting), testing::order_of(name, setting.beta), kOrder)
          << name;
    }
  EXPECT_NEAR(observed_order("imexv-thesis", setting), 1.0, 0.1);
}

TEST(Order, NewmarkIsOfFirstOrderWhereGammaIsNotOneHalf) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  const State exact = reference({});
  const auto error = [&](int steps) {
    IntegratorOptions options = precise_options(kDuration / steps);
    options.newmark_beta = 0.3025;
    options.newmark_gamma = 0.6;
    const auto integrator = make("newmark", model, options);
    State state = strong_state();
    testing::run(*integrator, state, {}, options.step, steps);
    return (state.q - exact.q).norm();
  };
  EXPECT_NEAR(std::log2(error(1600) / error(3200)), 1.0, 0.1);
}

TEST(Reversibility, MotionReturnsWhenTheMomentaAreTurnedRound) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  for (const char* name :
       {"verlet", "midpoint", "newmark", "imexv", "verlet4", "imexv-linear", "imexv-coupled"}) {
    const auto integrator = make(name, model, precise_options(1e-2));
    State state = strong_state();
    testing::run(*integrator, state, {}, 1e-2, 300);
    const State turning_point = state;
    state.p = -state.p;
    testing::run(*integrator, state, {}, 1e-2, 300);
    // Rounding and the solves' 1e-13, stretched by 600 steps of a nonlinear motion; a method that
    // does not return misses by more than 1e-3, see below.
    EXPECT_LE((state.q - strong_state().q).norm(), 1e-7) << name;
    EXPECT_LE((state.p + strong_state().p).norm(), 1e-6) << name;
    EXPECT_GE((turning_point.q - strong_state().q).norm(), 0.05) << name << " did not move";
  }
}

TEST(Reversibility, NewmarkWithGammaAboveOneHalfDoesNotReturn) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  IntegratorOptions options = precise_options(1e-2);
  options.newmark_beta = 0.3025;
  options.newmark_gamma = 0.6;
  const auto integrator = make("newmark", model, options);
  State state = strong_state();
  testing::run(*integrator, state, {}, 1e-2, 300);
  state.p = -state.p;
  testing::run(*integrator, state, {}, 1e-2, 300);
  EXPECT_GE((state.q - strong_state().q).norm(), 1e-3);
}

TEST(Reversibility, ContrastMethodsDoNotReturn) {
  const Model::Pointer model = testing::make_model(strong_strain_model());
  for (const char* name : {"explicit-euler", "implicit-euler", "rk2", "rk4"}) {
    const auto integrator = make(name, model, precise_options(5e-3));
    State state = strong_state();
    testing::run(*integrator, state, {}, 5e-3, 40);
    state.p = -state.p;
    testing::run(*integrator, state, {}, 5e-3, 40);
    // rk4 misses by 4e-6, the others by more; rounding is below 1e-12.
    EXPECT_GE((state.q - strong_state().q).norm(), 1e-6) << name;
  }
}

// max |J^T Omega J - Omega| of one step's derivative J, Omega the symplectic form.
double symplectic_defect(std::string_view name, const testing::StrainModel& strain) {
  const Model::Pointer model = testing::make_model(strain);
  const auto integrator = make(name, model, precise_options(2e-2));
  const Eigen::Index r = 4;
  const auto map = [&](const Eigen::VectorXd& z) {
    State state{z.head(r), z.tail(r)};
    testing::run(*integrator, state, {}, 2e-2, 1);
    Eigen::VectorXd image(2 * r);
    image << state.q, state.p;
    return image;
  };
  Eigen::VectorXd z(2 * r);
  z << strong_state().q, strong_state().p;
  Eigen::MatrixXd jacobian(2 * r, 2 * r);
  for (Eigen::Index i = 0; i < 2 * r; ++i) {
    const auto difference = [&](double s) {
      Eigen::VectorXd up = z, down = z;
      up[i] += s;
      down[i] -= s;
      return Eigen::VectorXd((map(up) - map(down)) / (2.0 * s));
    };
    const double s = i < r ? 1e-4 : 4e-3;
    jacobian.col(i) = (4.0 * difference(s) - difference(2.0 * s)) / 3.0;
  }
  Eigen::MatrixXd omega = Eigen::MatrixXd::Zero(2 * r, 2 * r);
  omega.topRightCorner(r, r).setIdentity();
  omega.bottomLeftCorner(r, r) = -Eigen::MatrixXd::Identity(r, r);
  return (jacobian.transpose() * omega * jacobian - omega).cwiseAbs().maxCoeff();
}

// Extrapolated differences are good to about 1e-10; entries of J reach 1e2.
constexpr double kSymplectic = 1e-7;

TEST(Symplecticity, VariationalMethodsKeepTheFormHoweverTheCoordinatesCouple) {
  for (const char* name : {"verlet", "midpoint", "verlet4", "imexv-linear", "imexv-coupled"})
    EXPECT_LE(symplectic_defect(name, strong_strain_model()), kSymplectic) << name;
}

TEST(Symplecticity, ContrastMethodsDoNotKeepTheForm) {
  for (const char* name : {"explicit-euler", "implicit-euler", "rk2", "rk4"})
    EXPECT_GE(symplectic_defect(name, strong_strain_model()), 1e3 * kSymplectic) << name;
}

TEST(Symplecticity, ImexvKeepsTheFormWhereLowAndHighDoNotCouple) {
  EXPECT_LE(symplectic_defect("imexv", strong_strain_model(2)), kSymplectic);
}

TEST(Symplecticity, ImexvDoesNotKeepTheFormWhereLowAndHighCouple) {
  EXPECT_GE(symplectic_defect("imexv", strong_strain_model()), 1e3 * kSymplectic);
}

TEST(Energy, UndampedEnergyOscillatesAndDoesNotDrift) {
  const testing::StrainModel strain = strong_strain_model();
  const Model::Pointer model = testing::make_model(strain);
  for (const char* name :
       {"verlet", "midpoint", "newmark", "imexv", "verlet4", "imexv-linear", "imexv-coupled"}) {
    const auto integrator = make(name, model, precise_options(2e-3));
    State state{0.4 * strong_state().q, 0.4 * strong_state().p};
    const auto energy = [&] {
      return 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
    };
    const double initial = energy();
    double worst = 0.0;
    for (int k = 0; k < 20000; ++k) {
      testing::run(*integrator, state, {}, 2e-3, 1);
      worst = std::max(worst, std::abs(energy() - initial) / initial);
    }
    // (h omega)^2/4 = 1.6e-3 at the highest frequency, a few times that where V stiffens; a drift
    // of one part in a million a step would reach it too.
    EXPECT_LE(worst, 0.01) << name;
  }
}

}  // namespace

// The closed forms of the frequencies that methods give a linear mode, against their steps.

namespace {

// The angle by which a linear oscillator rotates in a step, from four of its positions: they obey
// q_{n+1} = T q_n - D q_{n-1} with the trace T and the determinant D of the step.
double measured_angle(std::string_view name, double z, bool linear) {
  const IntegratorOptions options = testing::oscillator_options();
  const Eigen::VectorXd omega = Eigen::VectorXd::Constant(1, z / options.step);
  const Model::Pointer model =
      linear ? testing::linear_model(omega)
             : testing::make_model(testing::random_strain_model(omega, 0.0, 1));
  const auto integrator = testing::make(name, model, options);
  State state{Eigen::VectorXd::Constant(1, 0.3), Eigen::VectorXd::Constant(1, 0.1 * omega[0])};
  std::vector<double> q = {0.3};
  for (int n = 0; n < 5; ++n) {
    testing::run(*integrator, state, {}, options.step, 1);
    q.push_back(state.q[0]);
  }
  // A method that stores a staggered momentum takes the first step otherwise.
  Eigen::Matrix2d lines;
  lines << q[3], -q[2], q[4], -q[3];
  const Eigen::Vector2d found = lines.inverse() * Eigen::Vector2d(q[4], q[5]);
  return std::acos(found[0] / (2.0 * std::sqrt(found[1])));
}

TEST(Dispersion, TheClosedFormIsTheAngleOfTheStep) {
  int checked = 0;
  for (const std::string_view name : integrator_names())
    for (const double z : {0.1, 0.7, 1.3, 1.75, 2.3, 3.0, 3.1, 6.0}) {
      const auto angle = step_angle(name, z, testing::oscillator_options());
      if (!angle) continue;
      // Explicit Runge-Kutta methods rotate by an argument, which an arc cosine knows up to pi.
      if (*angle < 0.0) continue;
      EXPECT_NEAR(measured_angle(name, z, false), *angle, 1e-8) << name << " " << z;
      ++checked;
    }
  EXPECT_GT(checked, 80);
  EXPECT_NEAR(measured_angle("ep4", 2.5, true), 2.5, 1e-8);
  EXPECT_EQ(*step_angle("ep4", 2.5, {}, true), 2.5);
}

// The bell of 3 843 Hz in steps of 8 kHz that is heard at 3 092 Hz.
TEST(Dispersion, Ep4LowersWhatIsNearHalfTheRate) {
  const double h = 1.0 / 8000.0, z = 2.0 * std::numbers::pi * 3843.0 * h;
  EXPECT_NEAR(*step_angle("ep4", z, {}) / (2.0 * std::numbers::pi * h), 3092.0, 2.0);
  EXPECT_EQ(frequency_error("verlet", 2.5, {}), std::numeric_limits<double>::infinity());
  EXPECT_LT(frequency_error("ep2", 2.39, {}), 1e-14);
}

}  // namespace
}  // namespace tremolo
