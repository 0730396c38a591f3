// A body whose method explodes is stopped, and the others are not affected.
#include "runtime/energy_bound.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/crowd.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;

TEST(EnergyBound, FirstKickOfAnExplicitMethodIsNotJudgedByTheWorkThatLagsBehind) {
  EnergyBound bound;
  EXPECT_TRUE(bound.sound(0.0));
  bound.put_in(1e-3, 1.0);
  EXPECT_TRUE(bound.sound(1.0));
  EXPECT_TRUE(bound.sound(9.9));
  EXPECT_FALSE(bound.sound(10.1));
  EXPECT_TRUE(bound.holds(99.0));
  EXPECT_FALSE(bound.holds(101.0));
  EXPECT_FALSE(bound.holds(std::nan("")));
  EXPECT_FALSE(bound.holds(kNever));
}

TEST(EnergyBound, WorkThatIsTakenOutAgainStillCountsAsPutIn) {
  EnergyBound bound;
  bound.start(1.0);
  bound.put_in(4.0, 0.0);
  bound.put_in(-4.9, 0.0);
  EXPECT_TRUE(bound.sound(49.0));
  EXPECT_FALSE(bound.sound(51.0));
}

TEST(EnergyBound, WhatDampingHasTakenIsNotAllowedAgain) {
  EnergyBound bound;
  for (int push = 0; push < 1000; ++push) {
    bound.put_in(1.0, 1e-3);
    ASSERT_TRUE(bound.sound(1.0));
    bound.take_off_what_is_lost(1.0, 0.0);
    bound.take_off_what_is_lost(0.01, 0.0);
  }
  EXPECT_FALSE(bound.holds(200.0));  // of a thousand pushes of a joule
}

TEST(EnergyBound, RoundingOfAPotentialWhoseTermsCancelIsNoExplosion) {
  EnergyBound bound;
  bound.start(1e-9);
  EXPECT_FALSE(bound.holds(1e-6));
  EXPECT_TRUE(bound.holds(1e-6, 1.0));
}

TEST(EnergyBound, RoundingOfABodyAtRestIsNoExplosion) {
  EnergyBound bound;
  bound.put_in(1e-60, 0.0);
  EXPECT_FALSE(bound.holds(1e-45));
  const double rest = energy_at_rest(2.0, 0.4, 1e-3);
  EXPECT_DOUBLE_EQ(rest, 1.6e-17);  // 2 kg at 4e-9 m/s
  bound.set_rest(rest);
  EXPECT_EQ(bound.look(1e-45, 0.0), EnergyFound::kSound);
  EXPECT_TRUE(bound.sound(0.99 * rest));
  EXPECT_FALSE(bound.holds(1.01 * rest));
}

// h omega of the highest mode is 5.4 for the explicit methods, and a large motion stiffens what the
// others kick explicitly.
constexpr double kTooLong = 6e-3;
constexpr std::string_view kExploding[] = {"verlet",  "imexv-linear",   "imexv-thesis", "rk2",
                                           "verlet4", "explicit-euler", "rk4"};

// The first report that is not converged, at most `count` steps on.
StepReport step_until_failure(Body& body, int count) {
  for (int k = 0; k < count; ++k)
    if (const StepReport report = body.step(); !report.converged) return report;
  return {};
}

TEST(EnergyBound, BodyWhoseMethodExplodesSaysSoAndIsPutBackToASoundState) {
  for (const std::string_view method : kExploding) {
    Body body = std::move(*Body::create(crowd_model(0.05), method, {.step = kTooLong}));
    ASSERT_TRUE(body.apply_force(5, {30.0, -20.0, 40.0}, 1000));
    double most = 0.0;
    StepReport report;
    for (int k = 0; k < 1000 && report.converged; ++k) {
      // The energy that one step of this force gives a body at rest, and its work.
      const Eigen::VectorXd force = *reduce_force(body.model(), 5, {30.0, -20.0, 40.0});
      most = std::max({most, 0.5 * std::pow(kTooLong * force.norm(), 2.0), body.sums().work});
      report = body.step();
    }
    ASSERT_FALSE(report.converged) << method;
    EXPECT_EQ(report.failure, StepFailure::kEnergy) << method;
    EXPECT_LE(body.energy().total(), 10.0 * most) << method;
    EXPECT_LT(body.state().q.norm(), 100.0) << method;
    EXPECT_NE(failure_message(report, body.time()).find("exploded"), std::string::npos);
    // The failed step was not made, and its force still acts.
    const std::int64_t steps = body.counts().steps;
    EXPECT_TRUE(body.load_to_come());
    body.clear_forces();
    EXPECT_FALSE(body.load_to_come());
    ASSERT_TRUE(
        body.set_state(Eigen::VectorXd::Zero(kCrowdModes), Eigen::VectorXd::Zero(kCrowdModes)));
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(body.step().converged) << method;
    EXPECT_EQ(body.counts().steps, steps + 20);
  }
}

TEST(EnergyBound, WorkAndDissipationOfABodyThatIsPutBackBelongToTheStateItHas) {
  Body body = std::move(
      *Body::create(crowd_model(0.0), "verlet", {.step = 1.001 * 2.0 / 900.0, .alpha = 0.01}));
  ASSERT_TRUE(body.apply_force(5, {30.0, -20.0, 40.0}, 40));
  const StepReport report = step_until_failure(body, 5000);
  ASSERT_EQ(report.failure, StepFailure::kEnergy);
  const double excess = body.energy().total() - (body.sums().work - body.sums().dissipated);
  EXPECT_LE(std::abs(excess), 10.0 * body.sums().work);
  EXPECT_GT(body.sums().dissipated, 0.0);
}

TEST(EnergyBound, StateThatIsSetIsTheNewMeasure) {
  Body body = std::move(*Body::create(crowd_model(0.05)));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(kCrowdModes);
  for (const double size : {1e-6, 1e-2, 1e-5}) {
    ASSERT_TRUE(body.set_state(random_vector(kCrowdModes, size, 3), none));
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(body.step().converged) << size;
  }
  Body unstable = std::move(*Body::create(crowd_model(0.05), "verlet", {.step = kTooLong}));
  ASSERT_TRUE(unstable.set_state(random_vector(kCrowdModes, 1.0, 3), none));
  ASSERT_TRUE(unstable.set_state(random_vector(kCrowdModes, 1e-6, 3), none));
  const double energy = unstable.energy().total();
  ASSERT_EQ(step_until_failure(unstable, 200).failure, StepFailure::kEnergy);
  EXPECT_LE(unstable.energy().total(), 10.0 * energy);  // not of the large one before
}

// h omega just below two: T + V of a single mode oscillates by a factor of 40.
TEST(EnergyBound, StableMotionAtTheEdgeOfAnExplicitMethodIsNoExplosion) {
  const Model::Pointer model = testing::make_model(
      testing::random_strain_model(testing::spread_omega(1, 900.0, 900.0), 0, 1));
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(1), one = Eigen::VectorXd::Ones(1);
  for (const std::string_view method : {"verlet", "imexv-linear"}) {
    const IntegratorOptions options{.step = std::sqrt(1.0 - 1.0 / 40.0) * 2.0 / 900.0,
                                    .split = {.rule = SplitRule::kCount, .count = 1}};
    Body body = std::move(*Body::create(model, method, options));
    Crowd world = std::move(*Crowd::create());
    GroupOptions group{.integrator = method, .options = options};
    group.sleep.time = kNever;
    const BodyId lane = *world.add_body(*world.add_group(model, group));
    ASSERT_TRUE(body.set_state(zero, one));
    ASSERT_TRUE(world.set_state(lane, zero, one));
    double least = kNever, most = 0.0;
    for (int k = 0; k < 3000; ++k) {
      ASSERT_TRUE(body.step().converged) << method << k;
      ASSERT_TRUE(world.step().failed.empty()) << method << k;
      least = std::min(least, body.energy().total());
      most = std::max(most, body.energy().total());
    }
    EXPECT_GT(most, 30.0 * least);  // the case is what it says
  }
}

TEST(EnergyBound, SoundRunsOfEveryMethodWithLoadAndDampingNeverFail) {
  for (const std::string_view method : integrator_names())
    for (const double alpha : {0.0, 20.0}) {
      // explicit-euler and rk2 gain energy at any step: here a few percent.
      const double step = method == "explicit-euler"     ? 1e-6
                          : method == "rk2"              ? 1e-4
                          : testing::is_explicit(method) ? 5e-4
                                                         : 3e-3;
      Body body =
          std::move(*Body::create(crowd_model(0.02), method, {.step = step, .alpha = alpha}));
      ASSERT_TRUE(
          body.add_load({.kind = SignalKind::kSine, .frequency = 2.0}, 5, {0.5, 1.0, -0.7}));
      for (int k = 0; k < 2000; ++k) {
        if (k % 300 == 100) {
          ASSERT_TRUE(body.apply_force(5, {3.0, -2.0, 4.0}, 2));
        }
        const StepReport report = body.step();
        ASSERT_TRUE(report.converged) << method << " " << failure_message(report, body.time());
      }
    }
}

TEST(EnergyBound, LookingChangesNoOrbit) {
  for (const std::string_view method : integrator_names()) {
    const Model::Pointer model = crowd_model(0.05);
    const IntegratorOptions options{.step = testing::is_explicit(method) ? 1e-4 : 3e-3};
    Body body = std::move(*Body::create(model, method, options));
    State state{random_vector(kCrowdModes, 1e-3, 1), random_vector(kCrowdModes, 0.1, 2)};
    ASSERT_TRUE(body.set_state(state.q, state.p));
    const auto alone = testing::make(method, model, options);
    testing::run(*alone, state, {}, options.step, 100);
    for (int k = 0; k < 100; ++k) ASSERT_TRUE(body.step().converged);
    EXPECT_EQ(body.state().q, state.q) << method;
    EXPECT_EQ(body.state().p, state.p) << method;
  }
}

// ---- Crowd ----

struct LaneCase {
  std::string_view method;
  LanePrecision precision;
};
constexpr LaneCase kLaneCases[] = {{"verlet", LanePrecision::kDouble},
                                   {"verlet", LanePrecision::kFloat},
                                   {"imexv-linear", LanePrecision::kDouble},
                                   {"imexv-linear", LanePrecision::kFloat},
                                   {"imexv-thesis", LanePrecision::kDouble}};

// Bodies 0..count-1, of which every fifth has a state that explodes.
std::vector<BodyId> add_crowd(Crowd& world, GroupId group, unsigned count) {
  std::vector<BodyId> bodies;
  for (unsigned b = 0; b < count; ++b) {
    bodies.push_back(*world.add_body(group));
    const double size = b % 5 == 2 ? 0.3 : 1e-4;
    EXPECT_TRUE(world.set_state(bodies[b], random_vector(kCrowdModes, size, 100 + b),
                                Eigen::VectorXd::Zero(kCrowdModes)));
  }
  return bodies;
}

GroupOptions exploding_group(const LaneCase& lane) {
  GroupOptions options{.integrator = lane.method, .precision = lane.precision};
  options.options.step = lane.method == "verlet" ? 1.5e-3 : 3e-3;
  options.sleep.time = kNever;
  return options;
}

TEST(EnergyBound, BodyOfAWorldThatExplodesIsPutBackToASoundStateAndToSleepAndIsNamed) {
  const Model::Pointer model = crowd_model(0.5);
  for (const LaneCase& lane : kLaneCases) {
    Crowd world = std::move(*Crowd::create());
    const std::vector<BodyId> bodies =
        add_crowd(world, *world.add_group(model, exploding_group(lane)), 21);
    std::vector<double> start;
    for (const BodyId body : bodies) start.push_back(world.energy(body)->total());
    std::vector<BodyId> failed;
    for (int k = 0; k < 400; ++k) {
      const CrowdReport& report = world.step();
      ASSERT_EQ(report.failed.size(), report.why.size());
      for (std::size_t i = 0; i < report.failed.size(); ++i) {
        const BodyId body = report.failed[i];
        failed.push_back(body);
        EXPECT_EQ(report.why[i], StepFailure::kEnergy) << lane.method << body;
        EXPECT_FALSE(*world.is_awake(body));
        // Rounding of the float lanes' V relative to a V that is the model's own.
        EXPECT_LE(world.energy(body)->total(), 10.1 * start[body]) << lane.method << body;
      }
    }
    EXPECT_EQ(failed.size(), 4u) << lane.method;
    for (const BodyId body : failed) EXPECT_EQ(body % 5, 2u);
    // It tries again, and fails again, from where it was.
    ASSERT_TRUE(world.wake(2));
    std::size_t again = 0;
    for (int k = 0; k < 400; ++k) again += world.step().failed.size();
    EXPECT_EQ(again, 1u) << lane.method;
    EXPECT_LE(world.energy(2)->total(), 10.1 * start[2]) << lane.method;
  }
}

TEST(EnergyBound, WhereAnExplodedBodyIsPutDependsNeitherOnThreadsNorOnOthers) {
  const Model::Pointer model = crowd_model(0.5);
  const auto story = [&](const LaneCase& lane, unsigned threads, unsigned others) {
    Crowd world = std::move(*Crowd::create(threads));
    const GroupId group = *world.add_group(model, exploding_group(lane));
    add_crowd(world, group, 8);
    for (unsigned b = 0; b < others; ++b) {
      const BodyId other = *world.add_body(group);
      EXPECT_TRUE(world.set_state(other, random_vector(kCrowdModes, 0.2, 900 + b),
                                  random_vector(kCrowdModes, 1.0, 950 + b)));
    }
    for (int k = 0; k < 300; ++k) {
      if (k % 7 == 3 && others > 0) {
        EXPECT_TRUE(world.wake(8 + static_cast<unsigned>(k) % others));
      }
      world.step();
    }
    std::vector<State> states;
    for (BodyId body = 0; body < 8; ++body) states.push_back(*world.state(body));
    return states;
  };
  for (const LaneCase& lane : kLaneCases) {
    const std::vector<State> alone = story(lane, 1, 0);
    for (const unsigned threads : {1u, 3u}) {
      const std::vector<State> crowd = story(lane, threads, 37);
      for (std::size_t b = 0; b < alone.size(); ++b) {
        EXPECT_EQ(alone[b].q, crowd[b].q) << lane.method << b;
        EXPECT_EQ(alone[b].p, crowd[b].p) << lane.method << b;
      }
    }
  }
}

TEST(EnergyBound, ForcesOfALaneCountAsPutInAndSleepKeepsTheCount) {
  const Model::Pointer model = crowd_model(0.05);
  for (const LaneCase& lane : kLaneCases) {
    GroupOptions options{.integrator = lane.method, .precision = lane.precision};
    options.options.step = 1e-3;
    options.sleep.time = kNever;
    Crowd world = std::move(*Crowd::create());
    const BodyId body = *world.add_body(*world.add_group(model, options));
    for (int k = 0; k < 1000; ++k) {  // from rest, over and over, to 4e4 times the first energy
      if (k % 10 == 0) {
        ASSERT_TRUE(world.apply_force(body, 5, {1e-5 * k, -1e-4, 2e-4}, 3));
      }
      if (k % 30 == 7) {
        ASSERT_TRUE(world.sleep(body));
        ASSERT_TRUE(world.wake(body));
      }
      ASSERT_TRUE(world.step().failed.empty()) << lane.method << k;
    }
    EXPECT_GT(world.energy(body)->total(), 0.0);
  }
}

TEST(EnergyBound, ForceThatIsTooLargeIsRefusedOrNamedAndCanBeCleared) {
  const Model::Pointer model = crowd_model(0.05);
  Body body = std::move(*Body::create(model));
  const Status refused = body.apply_force(5, {1e308, -1e308, 1e308});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
  EXPECT_NE(refused.error().message.find("1e+308 N at vertex 5"), std::string::npos)
      << refused.error().message;
  EXPECT_FALSE(body.load_to_come());
  for (const std::string_view method : {"ep4", "verlet", "newmark", "imexv-linear"})
    for (const double size : {1e150, 1e120}) {
      Body pushed = std::move(*Body::create(model, method, {.step = 1e-3}));
      for (int k = 0; k < 4; ++k) ASSERT_TRUE(pushed.apply_force(5, {size, size, -size}, 5));
      const StepReport report = step_until_failure(pushed, 3);
      ASSERT_FALSE(report.converged) << method;
      EXPECT_EQ(report.failure, StepFailure::kLoad) << method << size;
      const std::string why = failure_message(report, 0.0);
      EXPECT_NE(why.find("overflow under the load"), std::string::npos) << why;
      pushed.clear_forces();
      EXPECT_TRUE(pushed.step().converged) << method << size;
      EXPECT_EQ(pushed.state().q, Eigen::VectorXd::Zero(kCrowdModes)) << method << size;
      const Eigen::VectorXd q = random_vector(kCrowdModes, 1e-3, 8);
      ASSERT_TRUE(pushed.set_state(q, Eigen::VectorXd::Zero(kCrowdModes)));
      EXPECT_TRUE(pushed.step().converged) << method << size;

      Crowd world = std::move(*Crowd::create());
      GroupOptions options{.integrator = method, .options = {.step = 1e-3}};
      const BodyId one = *world.add_body(*world.add_group(model, options));
      for (int k = 0; k < 4; ++k) ASSERT_TRUE(world.apply_force(one, 5, {size, size, -size}, 5));
      for (int k = 0; k < 3 && *world.is_awake(one); ++k) {
        const CrowdReport& made = world.step();
        if (!made.failed.empty()) {
          EXPECT_EQ(made.why[0], StepFailure::kLoad) << method << size;
        }
      }
      EXPECT_FALSE(*world.is_awake(one)) << method << size;
      EXPECT_EQ(world.state(one)->q, Eigen::VectorXd::Zero(kCrowdModes)) << method << size;
    }
}

TEST(EnergyBound, ForcesOfAWorldsBodyCanBeCleared) {
  for (const std::string_view method : {"ep4", "imexv-linear"}) {
    Crowd world = std::move(*Crowd::create());
    const GroupId group = *world.add_group(crowd_model(0.05), {.integrator = method});
    const BodyId pushed = *world.add_body(group), other = *world.add_body(group);
    for (const BodyId body : {pushed, other})
      ASSERT_TRUE(world.apply_force(body, 5, {1.0, 0.0, 0.0}, 50));
    ASSERT_TRUE(world.clear_forces(pushed));
    EXPECT_TRUE(*world.is_awake(pushed));
    world.step();
    EXPECT_EQ(world.state(pushed)->q, Eigen::VectorXd::Zero(kCrowdModes)) << method;
    EXPECT_NE(world.state(other)->q, Eigen::VectorXd::Zero(kCrowdModes)) << method;
    EXPECT_FALSE(world.clear_forces(7));
  }
}

TEST(Crowd, DefaultMethodIsOneThatCannotExplode) {
  EXPECT_EQ(GroupOptions{}.integrator, "ep4");
  Crowd world = std::move(*Crowd::create());
  const Model::Pointer model = crowd_model(0.5);
  const GroupId group = *world.add_group(model, {});
  const BodyId body = *world.add_body(group);
  // The state that explodes in lanes at the same step.
  ASSERT_TRUE(world.set_state(body, random_vector(kCrowdModes, 0.3, 102),
                              Eigen::VectorXd::Zero(kCrowdModes)));
  const double energy = world.energy(body)->total();
  for (int k = 0; k < 400; ++k) ASSERT_TRUE(world.step().failed.empty()) << k;
  EXPECT_NEAR(world.energy(body)->total(), energy, 1e-9 * energy);
}

}  // namespace
}  // namespace tremolo
