// Damping by a ratio of each mode: the decay of small motion, alpha as ratios, energy, lanes, saved
// states, and what is refused.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/body.h"
#include "runtime/contact_body.h"
#include "runtime/crowd.h"
#include "runtime/tremolo.h"
#include "tests/support/dynamics.h"
#include "tests/support/linear_model.h"

namespace tremolo {
namespace {

using namespace testing;
using Eigen::VectorXd;

const std::vector<double> kRatios = {0.02, 0.005, 0.04};  // the fourth mode has the last one

DampingRatios some_ratios() {
  DampingRatios ratios;
  ratios.of_modes = kRatios;
  return ratios;
}

// ---- small motion of one mode against e^{-zeta omega t} ----

constexpr double kSmall = 1e-15;  // of q: forces of higher degree are below rounding
constexpr double kTime = 0.4;     // s

struct Oscillator {
  double omega = 0.0;
  double ratio = 0.0;

  double damped() const { return omega * std::sqrt(1.0 - ratio * ratio); }
  // From q = 1 at rest.
  double q(double t) const {
    return std::exp(-ratio * omega * t) *
           (std::cos(damped() * t) + ratio * omega / damped() * std::sin(damped() * t));
  }
  double p(double t) const {
    return -std::exp(-ratio * omega * t) * omega * omega / damped() * std::sin(damped() * t);
  }
  // The amplitude of the orbit through (q, p), without its decay.
  double amplitude(double q, double p) const {
    return std::hypot(q, (p + ratio * omega * q) / damped());
  }
};

struct Decay {
  double rate = 0.0;   // measured, 1/s
  double error = 0.0;  // of the state at the end, relative to the start
};

Decay measure(std::string_view name, Eigen::Index mode, int steps) {
  const StrainModel strains = strong_strain_model();
  const Model::Pointer model = make_model(strains);
  IntegratorOptions options{.step = kTime / steps};
  options.split = {.rule = SplitRule::kCount, .count = 2};
  options.tolerance = 1e-13;
  options.ratios = some_ratios();
  const auto integrator = make(name, model, options);
  const auto known = static_cast<std::size_t>(mode);
  const Oscillator exact{strains.omega[mode], kRatios[std::min(known, kRatios.size() - 1)]};
  State state{kSmall * VectorXd::Unit(4, mode), VectorXd::Zero(4)};
  testing::run(*integrator, state, {}, options.step, steps);
  const double q1 = state.q[mode] / kSmall, p1 = state.p[mode] / kSmall;
  EXPECT_LE((state.q - state.q[mode] * VectorXd::Unit(4, mode)).norm(), 1e-6 * kSmall) << name;
  return {std::log(exact.amplitude(1.0, 0.0) / exact.amplitude(q1, p1)) / kTime,
          std::hypot(q1 - exact.q(kTime), (p1 - exact.p(kTime)) / exact.omega)};
}

TEST(DampingRatio, EachModeDecaysByItsOwnRatio) {
  const VectorXd omega = strong_strain_model().omega;
  for (const std::string_view name : integrator_names()) {
    if (order_of(name) == 1 || name == "imexv-thesis") continue;  // their rate has an error of h
    for (Eigen::Index mode = 0; mode < 4; ++mode) {
      const double rate = kRatios[std::min<std::size_t>(static_cast<std::size_t>(mode), 2)];
      // h omega <= 0.02: methods of second order are off by its square over 12 in the amplitude of
      // the orbit, which is 3e-5 at most, of at least ratio omega t = 0.014 in its logarithm.
      EXPECT_NEAR(measure(name, mode, 800).rate, rate * omega[mode], 2e-3 * rate * omega[mode])
          << name << " mode " << mode;
    }
  }
}

TEST(DampingRatio, SmallMotionIsOfTheMethodsOrder) {
  for (const std::string_view name : integrator_names()) {
    if (name == "imexv-thesis") continue;  // its solve's tolerance is one of q itself
    for (const Eigen::Index mode : {1, 3}) {
      const int order = order_of(name);
      const int steps = order == 1 ? 6400 : order == 2 ? 800 : 100;
      const double coarse = measure(name, mode, steps).error;
      const double fine = measure(name, mode, 2 * steps).error;
      // Methods whose linear motion is exact have rounding alone, some 1e-16 a step.
      if (coarse < 1e-11) continue;
      EXPECT_GT(std::log2(coarse / fine), order - 0.1) << name << " mode " << mode << " " << coarse;
    }
  }
}

TEST(DampingRatio, OfALinearModelIsTheClosedFormAtAnyStep) {
  const VectorXd omega = Eigen::Vector4d(3.0, 40.0, 700.0, 9000.0);
  const Model::Pointer model = linear_model(omega);
  IntegratorOptions options{.step = 0.01};
  options.ratios = some_ratios();
  const auto integrator = make("ep4", model, options);
  State state{VectorXd::Ones(4), VectorXd::Zero(4)};
  testing::run(*integrator, state, {}, options.step, 10);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Oscillator exact{omega[i],
                           kRatios[std::min<std::size_t>(static_cast<std::size_t>(i), 2)]};
    // The phase of 900 radians is rounded.
    EXPECT_NEAR(state.q[i], exact.q(0.1), 1e-12) << i;
    EXPECT_NEAR(state.p[i], exact.p(0.1), 1e-12 * omega[i]) << i;
  }
}

// ---- alpha as ratios ----

// Ratios that give every coordinate the rate alpha.
DampingRatios ratios_of_alpha(const Model& model, double alpha) {
  DampingRatios ratios;
  for (const double lambda : model.lambda())
    ratios.of_modes.push_back(0.5 * alpha / std::sqrt(lambda));
  return ratios;
}

// In every method the orbit and the dissipated energy are those of alpha, up to the rounding of
// 2 zeta omega, which 100 steps of strong motion amplify.
TEST(DampingRatio, RatiosThatGiveEveryModeTheSameRateAreDampingOfTheMass) {
  const Model::Pointer model = crowd_model();
  for (const std::string_view method : integrator_names()) {
    const double step = is_explicit(method) || order_of(method) == 1 ? 2e-4 : 2e-3;
    IntegratorOptions mass{.step = step, .alpha = 1.7}, ratios{.step = step};
    mass.tolerance = ratios.tolerance = 1e-12;
    ratios.ratios = ratios_of_alpha(*model, 1.7);
    Body a = std::move(*Body::create(model, method, mass));
    Body b = std::move(*Body::create(model, method, ratios));
    const State start{random_vector(kCrowdModes, 0.02, 100), random_vector(kCrowdModes, 1.0, 500)};
    for (Body* body : {&a, &b}) {
      ASSERT_TRUE(body->set_state(start.q, start.p));
      for (int k = 0; k < 100; ++k) ASSERT_TRUE(body->step().converged) << method;
    }
    EXPECT_LE((a.state().q - b.state().q).norm(), 1e-9 * a.state().q.norm()) << method;
    EXPECT_LE((a.state().p - b.state().p).norm(), 1e-9 * a.state().p.norm()) << method;
    EXPECT_NEAR(a.sums().dissipated, b.sums().dissipated, 1e-9 * a.sums().dissipated) << method;
  }
}

// ---- energy, lanes, saved states ----

TEST(DampingRatio, TheEnergyThatIsMissingWasDissipated) {
  const Model::Pointer model = crowd_model();
  for (const char* method : {"avf", "ep2", "ep4"}) {
    IntegratorOptions options{.step = 3e-3};
    options.ratios = some_ratios();
    Body body = std::move(*Body::create(model, method, options));
    ASSERT_TRUE(
        body.set_state(random_vector(kCrowdModes, 0.06, 1), random_vector(kCrowdModes, 3.0, 2)));
    const double start = body.energy().total();
    for (int k = 0; k < 1000; ++k) ASSERT_TRUE(body.step().converged);
    EXPECT_LT(body.energy().total(), 0.9 * start);
    // Every step balances to rounding.
    EXPECT_NEAR(body.energy().total() + body.sums().dissipated, start, 1e-12 * start) << method;
  }
}

TEST(DampingRatio, BodiesInLanesMoveAsOneBody) {
  const Model::Pointer model = crowd_model();
  for (const char* method : {"avf", "ep2", "ep4", "verlet", "imexv-linear"}) {
    GroupOptions group;
    group.integrator = method;
    group.options = {.step = std::string(method) == "verlet" ? 5e-4 : 2e-3};
    group.options.tolerance = 1e-12;
    group.options.ratios = some_ratios();
    group.sleep.time = kNever;
    Crowd world = std::move(*Crowd::create(1));
    const GroupId id = *world.add_group(model, group);
    std::vector<Body> bodies;
    for (unsigned b = 0; b < 9; ++b) {
      const BodyId added = *world.add_body(id);
      bodies.push_back(std::move(*Body::create(model, method, group.options)));
      const VectorXd q = random_vector(kCrowdModes, 0.01, 10 + b);
      const VectorXd p = random_vector(kCrowdModes, 0.5, 30 + b);
      ASSERT_TRUE(world.set_state(added, q, p));
      ASSERT_TRUE(bodies.back().set_state(q, p));
    }
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(world.step().failed.empty());
      for (Body& body : bodies) ASSERT_TRUE(body.step().converged);
    }
    for (unsigned b = 0; b < 9; ++b) {
      const State lane = *world.state(b), &one = bodies[b].state();
      // Sums in another order, over 200 steps.
      EXPECT_LE((lane.q - one.q).norm(), 1e-8 * one.q.norm()) << method;
      EXPECT_LE((lane.p - one.p).norm(), 1e-8 * one.p.norm()) << method;
    }
  }
}

TEST(DampingRatio, IsSavedAndRestoredToTheBit) {
  const Model::Pointer model = crowd_model();
  for (const std::string_view method : integrator_names()) {
    const IntegratorOptions options{.step = is_explicit(method) ? 2e-4 : 2e-3};
    Body body = std::move(*Body::create(model, method, options));
    DampingRatios table;
    table.table = {{1.0, 0.02}, {20.0, 0.01}, {90.0, 0.03}};
    ASSERT_TRUE(body.set_damping(table));
    ASSERT_TRUE(body.apply_force(5, {1.0, 2.0, 3.0}, 30));
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(body.step().converged);
    // Into a body that was made without damping.
    Body other = std::move(*Body::create(model, method, options));
    ASSERT_TRUE(other.restore(body.save())) << method;
    EXPECT_EQ(damping_of(other.options()), table);
    for (int k = 0; k < 30; ++k) {
      ASSERT_TRUE(body.step().converged);
      ASSERT_TRUE(other.step().converged);
    }
    EXPECT_EQ(body.state().q, other.state().q) << method;
    EXPECT_EQ(body.sums().dissipated, other.sums().dissipated) << method;
  }
}

// ---- what is replaced and what is refused ----

TEST(DampingRatio, ReplacesAlphaAndBetaAndIsReplacedByThem) {
  ContactBody body = std::move(*ContactBody::create(crowd_model(), "ep4", {.alpha = 1.0}));
  ASSERT_TRUE(body.set_damping(some_ratios()));
  EXPECT_EQ(body.options().alpha, 0.0);
  EXPECT_EQ(body.options().ratios, some_ratios());
  ASSERT_TRUE(body.set_damping(0.5, 0.0));
  EXPECT_FALSE(body.options().ratios.of_each_mode());
  EXPECT_EQ(body.options().alpha, 0.5);
}

TEST(DampingRatio, OutOfRangeOrTooManyAreRefused) {
  const Model::Pointer model = crowd_model();
  const auto made = [&](std::vector<double> of_modes, std::vector<RatioAt> table = {}) {
    IntegratorOptions options;
    options.ratios.of_modes = std::move(of_modes);
    options.ratios.table = std::move(table);
    return make_integrator("ep4", model, options);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(made(std::vector<double>(kCrowdModes, 0.01)));
  for (const auto& ratios : {std::vector<double>{-0.01},
                             {0.1, kNan},
                             {1.0},
                             std::vector<double>(kCrowdModes + 1, 0.01)}) {
    const auto wrong = made(ratios);
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().kind, ErrorKind::kContent);
  }
  EXPECT_NE(made(std::vector<double>(12, 0.01)).error().message.find("there are 9 modes"),
            std::string::npos);
  EXPECT_FALSE(made({}, {{2.0, 0.1}, {1.0, 0.1}}));
  EXPECT_FALSE(made({}, {{1.0, 0.1}, {2.0, kNan}}));
  EXPECT_FALSE(made({0.1}, {{1.0, 0.1}, {2.0, 0.1}}));
  ContactBody body = std::move(*ContactBody::create(model, "ep4", {.alpha = 1.0}));
  DampingRatios wrong;
  wrong.of_modes = {2.0};
  EXPECT_FALSE(body.set_damping(wrong));
  EXPECT_EQ(body.options().alpha, 1.0);
  EXPECT_FALSE(body.options().ratios.of_each_mode());
  // A group of fewer modes than the model has.
  Crowd world = std::move(*Crowd::create(1));
  GroupOptions group;
  group.integrator = "verlet";
  group.options = {.step = 5e-4};
  group.options.ratios = some_ratios();
  group.modes = 2;
  const auto refused = world.add_group(model, group);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
}

}  // namespace
}  // namespace tremolo
