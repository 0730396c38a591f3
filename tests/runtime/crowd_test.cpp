#include "runtime/crowd.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;

// With a step of 3 ms imexv-linear has three rows above its split; verlet needs a shorter one.
GroupOptions group_options(std::string_view integrator, double alpha = 0.3, double beta = 0.0) {
  GroupOptions options;
  options.integrator = integrator;
  options.options = {.step = integrator == "verlet" ? 1e-3 : 3e-3, .alpha = alpha, .beta = beta};
  options.sleep.time = kNever;
  return options;
}

Eigen::VectorXd some_q(unsigned body) {
  return random_vector(kCrowdModes, 0.02, 100 + body);
}
Eigen::VectorXd some_p(unsigned body) {
  return random_vector(kCrowdModes, 1.0, 500 + body);
}

struct Troop {
  Crowd crowd;
  GroupId group;
  std::vector<BodyId> bodies;
};

Troop make_troop(const Model::Pointer& model, const GroupOptions& options, unsigned count,
                 unsigned threads = 1) {
  Troop troop{std::move(*Crowd::create(threads)), 0, {}};
  const Result<GroupId> group = troop.crowd.add_group(model, options);
  EXPECT_TRUE(group) << (group ? "" : group.error().message);
  troop.group = *group;
  for (unsigned b = 0; b < count; ++b) {
    troop.bodies.push_back(*troop.crowd.add_body(troop.group));
    EXPECT_TRUE(troop.crowd.set_state(troop.bodies.back(), some_q(b), some_p(b)));
  }
  return troop;
}

// The largest difference of q and of p to Body after `steps` steps with forces, relative to the
// largest q and p.
double difference_to_bodies(const Model::Pointer& model, const GroupOptions& options, int steps) {
  constexpr unsigned kCount = 21;  // a whole block, and one that is not full
  Troop troop = make_troop(model, options, kCount, 2);
  std::vector<Body> bodies;
  for (unsigned b = 0; b < kCount; ++b) {
    bodies.push_back(std::move(*Body::create(model, options.integrator, options.options)));
    EXPECT_TRUE(bodies.back().set_state(some_q(b), some_p(b)));
  }
  for (int k = 0; k < steps; ++k) {
    if (k % 7 == 3)
      for (unsigned b = 0; b < kCount; b += 2) {
        const Eigen::Vector3d force(0.5 * b, -3.0, 2.0);
        EXPECT_TRUE(troop.crowd.apply_force(troop.bodies[b], 5, force, 2 + k % 3));
        EXPECT_TRUE(bodies[b].apply_force(5, force, 2 + k % 3));
      }
    const CrowdReport& report = troop.crowd.step();
    EXPECT_EQ(report.stepped, kCount);
    EXPECT_TRUE(report.failed.empty());
    for (Body& body : bodies) EXPECT_TRUE(body.step().converged);
  }
  double q = 0.0, p = 0.0, dq = 0.0, dp = 0.0;
  for (unsigned b = 0; b < kCount; ++b) {
    const State state = *troop.crowd.state(troop.bodies[b]);
    q = std::max(q, bodies[b].state().q.norm());
    p = std::max(p, bodies[b].state().p.norm());
    dq = std::max(dq, (state.q - bodies[b].state().q).norm());
    dp = std::max(dp, (state.p - bodies[b].state().p).norm());
  }
  return std::max(dq / q, dp / p);
}

TEST(Crowd, LanesInDoubleMoveAsBodiesDo) {
  for (const std::string_view method : {"verlet", "imexv-linear"})
    for (const bool damped : {false, true}) {
      const GroupOptions options = group_options(method, damped ? 0.3 : 0.0, damped ? 1e-6 : 0.0);
      // Rounding of 1e-16 a step, and neighbouring orbits part no faster than in proportion to
      // time.
      EXPECT_LE(difference_to_bodies(crowd_model(), options, 300), 1e-12) << method << damped;
    }
}

TEST(Crowd, LanesInFloatMoveAsBodiesDoToFloatRounding) {
  for (const std::string_view method : {"verlet", "imexv-linear"}) {
    GroupOptions options = group_options(method);
    options.precision = LanePrecision::kFloat;
    const double difference = difference_to_bodies(crowd_model(), options, 300);
    // 6e-8 of the nonlinear force a step; the state itself is double.
    EXPECT_LE(difference, 3e-6) << method;
    EXPECT_GT(difference, 1e-12) << method;  // it is float that was asked for
  }
}

TEST(Crowd, LanesInFloatAreExactWhereTheModelIsLinear) {
  GroupOptions options = group_options("imexv-linear");
  options.precision = LanePrecision::kFloat;
  EXPECT_LE(difference_to_bodies(crowd_model(0.0), options, 300), 1e-12);
}

TEST(Crowd, OtherMethodsAreBodies) {
  EXPECT_EQ(difference_to_bodies(crowd_model(), group_options("newmark"), 30), 0.0);
}

// Lanes have the damping of the rest shape alone.
TEST(Crowd, GroupsWhoseDampingFeelsStrainsAreBodiesWithAllCoordinates) {
  for (const char* method : {"verlet", "imexv-linear"}) {
    GroupOptions options = group_options(method, 0.3, 1e-6);
    EXPECT_EQ(difference_to_bodies(crowd_model(), options, 30), 0.0) << method;
    options.modes = 5;
    Crowd crowd = std::move(*Crowd::create());
    const auto refused = crowd.add_group(crowd_model(), options);
    ASSERT_FALSE(refused) << method;
    EXPECT_NE(refused.error().message.find("beta > 0"), std::string::npos);
  }
}

// A crowd of three groups in which bodies are pushed, fail, sleep and wake; all states at its end.
std::vector<State> busy_story(unsigned threads) {
  const Model::Pointer model = crowd_model();
  Crowd crowd = std::move(*Crowd::create(threads));
  std::vector<GroupId> groups;
  for (const std::string_view method : {"imexv-linear", "verlet", "ep4"}) {
    GroupOptions options = group_options(method, 10.0, 1e-5);
    options.precision = method == "verlet" ? LanePrecision::kFloat : LanePrecision::kDouble;
    options.sleep = {.energy = 1e-2, .time = 0.05};
    groups.push_back(*crowd.add_group(model, options));
  }
  std::vector<BodyId> bodies;
  for (unsigned b = 0; b < 90; ++b) {
    bodies.push_back(*crowd.add_body(groups[b % 3]));
    EXPECT_TRUE(crowd.set_state(bodies[b], some_q(b), some_p(b)));
    EXPECT_TRUE(crowd.set_shown(bodies[b], b % 10 == 0));
  }
  std::size_t slept = 0, failed = 0;
  for (unsigned k = 0; k < 400; ++k) {
    if (k % 5 == 0 && k < 150) {
      EXPECT_TRUE(crowd.apply_force(bodies[(7 * k) % 90], 5, {3.0, 1.0 * (k % 11), -2.0}, 3));
    }
    if (k == 50) {
      for (const unsigned b : {3u, 4u})
        EXPECT_TRUE(crowd.set_state(bodies[b], Eigen::VectorXd::Constant(kCrowdModes, 1e200),
                                    Eigen::VectorXd::Zero(kCrowdModes)));
    }
    const CrowdReport& report = crowd.step();
    slept += report.fell_asleep;
    failed += report.failed.size();
    crowd.update_surfaces();
  }
  EXPECT_GT(slept, 10u);
  EXPECT_GE(failed, 2u);
  std::vector<State> states;
  for (const BodyId body : bodies) states.push_back(*crowd.state(body));
  return states;
}

TEST(Crowd, ResultIsTheSameBitForBitWithAnyNumberOfThreads) {
  const std::vector<State> alone = busy_story(1);
  for (const unsigned threads : {2u, 3u, 5u}) {
    const std::vector<State> shared = busy_story(threads);
    for (std::size_t b = 0; b < alone.size(); ++b) {
      EXPECT_EQ(alone[b].q, shared[b].q) << threads << " threads, body " << b;
      EXPECT_EQ(alone[b].p, shared[b].p);
    }
  }
}

TEST(Crowd, BodyDoesNotFeelTheOthersComeAndGo) {
  const Model::Pointer model = crowd_model();
  const GroupOptions options = group_options("imexv-linear");
  Troop alone = make_troop(model, options, 1);
  Troop troop = make_troop(model, options, 30);
  std::mt19937 random(5);
  for (int k = 0; k < 200; ++k) {
    // The body itself loses its lane, gets the last one and may be moved on at once.
    if (k % 4 == 1) {
      ASSERT_TRUE(troop.crowd.sleep(0));
      ASSERT_TRUE(troop.crowd.wake(0));
    }
    for (int change = 0; change < 6; ++change) {
      const BodyId other = troop.bodies[1 + random() % 29];
      ASSERT_TRUE(random() % 2 == 0 ? troop.crowd.sleep(other) : troop.crowd.wake(other));
    }
    alone.crowd.step();
    troop.crowd.step();
  }
  EXPECT_EQ(alone.crowd.state(0)->q, troop.crowd.state(0)->q);
  EXPECT_EQ(alone.crowd.state(0)->p, troop.crowd.state(0)->p);
}

TEST(Crowd, NewBodySleepsAndAForceWakesIt) {
  Crowd crowd = std::move(*Crowd::create());
  const GroupId group = *crowd.add_group(crowd_model(), group_options("verlet"));
  const BodyId body = *crowd.add_body(group);
  EXPECT_FALSE(*crowd.is_awake(body));
  EXPECT_EQ(crowd.step().stepped, 0u);
  ASSERT_TRUE(crowd.apply_force(body, 5, {1.0, 0.0, 0.0}));
  EXPECT_EQ(crowd.step().stepped, 1u);
  EXPECT_GT(crowd.energy(body)->total(), 0.0);
}

TEST(Crowd, DampedBodyFallsAsleepBelowTheThresholdAndMovesOnFromThere) {
  const Model::Pointer model = crowd_model();
  for (const std::string_view method : {"imexv-linear", "ep4"}) {
    GroupOptions options = group_options(method, 3.0);
    options.sleep = {.energy = 1e-3, .time = 0.1};
    Troop troop = make_troop(model, options, 3);
    int steps = 0;
    while (troop.crowd.awake() > 0 && ++steps < 5000) troop.crowd.step();
    ASSERT_EQ(troop.crowd.awake(), 0u) << method;
    const State frozen = *troop.crowd.state(1);
    EXPECT_GT(frozen.q.norm(), 0.0);
    EXPECT_LE(troop.crowd.energy(1)->total(), 1e-3);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(troop.crowd.step().stepped, 0u);
    EXPECT_EQ(troop.crowd.state(1)->q, frozen.q);
    ASSERT_TRUE(troop.crowd.wake(1));
    EXPECT_EQ(troop.crowd.state(1)->p, frozen.p);
    Body body = std::move(*Body::create(model, method, options.options));
    ASSERT_TRUE(body.set_state(frozen.q, frozen.p));
    troop.crowd.step();
    body.step();
    // Rounding of one step; an ep4 that continues still has the filter of its last step, so that
    // the two solves end at different points within their tolerance.
    const double allowed = method == "ep4" ? 1e-9 : 1e-14;
    EXPECT_LE((troop.crowd.state(1)->q - body.state().q).norm(), allowed * frozen.q.norm());
  }
}

TEST(Crowd, BodyStaysAwakeForTheTimeAskedAndWhileAForceActs) {
  GroupOptions options = group_options("imexv-linear");
  options.sleep = {.energy = 1e6, .time = 0.3};
  Troop troop = make_troop(crowd_model(), options, 2);
  ASSERT_TRUE(troop.crowd.apply_force(1, 5, {1.0, 0.0, 0.0}, 400));
  int steps = 0;
  while (*troop.crowd.is_awake(0)) {
    troop.crowd.step();
    ASSERT_LT(++steps, 1000);
  }
  EXPECT_GE(steps * options.options.step, 0.3 - 1e-9);
  EXPECT_LE(steps * options.options.step, 0.3 + 8 * options.options.step);  // checked every 8th
  while (steps++ < 399) troop.crowd.step();
  EXPECT_TRUE(*troop.crowd.is_awake(1));
  for (int k = 0; k < 200; ++k) troop.crowd.step();
  EXPECT_FALSE(*troop.crowd.is_awake(1));
}

TEST(Crowd, WhatSleepsByDefaultIsMovedByLessThanATenThousandthOfItsSize) {
  const Model::Pointer model = crowd_model();
  GroupOptions options = group_options("imexv-linear", 3.0);
  options.sleep = {.time = 0.1};
  Troop troop = make_troop(model, options, 5);
  for (int k = 0; k < 20000 && troop.crowd.awake() > 0; ++k) troop.crowd.step();
  ASSERT_EQ(troop.crowd.awake(), 0u);
  Eigen::Vector3d least = model->surface().rest[0], most = least;
  for (const Eigen::Vector3d& rest : model->surface().rest) {
    least = least.cwiseMin(rest);
    most = most.cwiseMax(rest);
  }
  for (const BodyId body : troop.bodies) {
    const Eigen::VectorXd moved = model->surface().rows * troop.crowd.state(body)->q;
    // The bound holds exactly for the first mode; the others, which this model lets move as far at
    // higher frequency, are below it.
    EXPECT_LE(moved.cwiseAbs().maxCoeff(), 1.2e-4 * (most - least).maxCoeff());
  }
}

TEST(Crowd, BodyThatLeavesTheNumbersIsPutBackAndToSleepAndHarmsNoOther) {
  const Model::Pointer model = crowd_model();
  const Eigen::VectorXd huge = Eigen::VectorXd::Constant(kCrowdModes, 1e200);
  for (const std::string_view method : {"verlet", "imexv-linear", "ep4"})
    for (const BodyId bad : {5u, 11u}) {  // amid the others, and the last
      const GroupOptions options = group_options(method);
      Troop troop = make_troop(model, options, 12), without = make_troop(model, options, 12);
      ASSERT_TRUE(troop.crowd.set_state(bad, huge, huge));
      ASSERT_TRUE(troop.crowd.apply_force(bad, 5, {1.0, 0.0, 0.0}, 9));
      const CrowdReport& report = troop.crowd.step();
      ASSERT_EQ(report.failed.size(), 1u) << method;
      EXPECT_EQ(report.failed[0], bad);
      EXPECT_FALSE(*troop.crowd.is_awake(bad));
      EXPECT_EQ(troop.crowd.state(bad)->q, huge);
      EXPECT_EQ(troop.crowd.state(bad)->p, huge);
      without.crowd.step();
      for (int k = 0; k < 20; ++k) {
        EXPECT_TRUE(troop.crowd.step().failed.empty());
        without.crowd.step();
      }
      for (const BodyId body : troop.bodies) {
        if (body != bad) {
          EXPECT_EQ(troop.crowd.state(body)->q, without.crowd.state(body)->q);
        }
      }
    }
}

TEST(Crowd, BodiesThatFallAsleepTogetherAreThoseAndNoOthers) {
  const Model::Pointer model = crowd_model();
  for (const std::string_view method : {"imexv-linear", "ep4"}) {
    GroupOptions options = group_options(method);
    Troop awake = make_troop(model, options, 21);
    options.sleep = {.energy = 1e6, .time = 0.02};  // the first look finds all of them quiet
    Troop troop = make_troop(model, options, 21);
    for (BodyId body = 0; body < 21; body += 3)
      for (Crowd* crowd : {&awake.crowd, &troop.crowd})
        ASSERT_TRUE(crowd->apply_force(body, 5, {1.0, 0.0, 0.0}, 12));
    std::size_t slept = 0;
    for (int k = 0; k < 12; ++k) {
      slept += troop.crowd.step().fell_asleep;
      awake.crowd.step();
    }
    EXPECT_EQ(slept, 14u) << method;
    for (BodyId body = 0; body < 21; ++body) {
      EXPECT_EQ(*troop.crowd.is_awake(body), body % 3 == 0);
      if (body % 3 == 0) {
        EXPECT_EQ(troop.crowd.state(body)->q, awake.crowd.state(body)->q);
      }
    }
  }
}

TEST(Crowd, SurfacesAreRebuiltForBodiesThatMovedAndAreShown) {
  const Model::Pointer model = crowd_model();
  Troop troop = make_troop(model, group_options("imexv-linear"), 11);
  Crowd& crowd = troop.crowd;
  EXPECT_EQ(crowd.update_surfaces(), 0u);
  EXPECT_FALSE(crowd.surface(2));
  for (BodyId body = 0; body < 7; ++body) ASSERT_TRUE(crowd.set_shown(body, true));
  EXPECT_EQ(crowd.surface(2)->version, 0u);
  EXPECT_EQ(crowd.update_surfaces(), 7u);
  EXPECT_EQ(crowd.update_surfaces(), 0u);
  ASSERT_TRUE(crowd.sleep(3));
  crowd.step();
  EXPECT_EQ(crowd.update_surfaces(), 6u);
  EXPECT_EQ(crowd.surface(2)->version, 2u);
  EXPECT_EQ(crowd.surface(3)->version, 1u);
  ASSERT_TRUE(crowd.set_shown(2, false));
  EXPECT_FALSE(crowd.surface(2));
  ASSERT_TRUE(crowd.set_state(3, some_q(77), some_p(77)));
  EXPECT_EQ(crowd.update_surfaces(), 1u);
  crowd.step();
  ASSERT_TRUE(crowd.sleep(4));  // has moved before it slept
  EXPECT_EQ(crowd.update_surfaces(), 6u);
  for (const BodyId body : {0u, 1u, 3u, 4u, 5u, 6u}) {
    Body reference = std::move(*Body::create(model, "imexv-linear", {}));
    const State state = *crowd.state(body);
    ASSERT_TRUE(reference.set_state(state.q, state.p));
    std::vector<double> expected(15);
    ASSERT_TRUE(reference.surface_positions(std::span<double>(expected)));
    const std::span<const float> positions = crowd.surface(body)->positions;
    ASSERT_EQ(positions.size(), 15u);
    for (std::size_t i = 0; i < 15; ++i)  // float rounding of positions below 3
      EXPECT_NEAR(positions[i], expected[i], 3e-7);
  }
}

TEST(Crowd, SurfaceOfABodyThatFellAsleepIsItsLast) {
  GroupOptions options = group_options("imexv-linear", 3.0);
  options.sleep = {.energy = 1e-2, .time = 0.01};
  Troop troop = make_troop(crowd_model(), options, 1);
  ASSERT_TRUE(troop.crowd.set_shown(0, true));
  int steps = 0;
  while (troop.crowd.awake() > 0 && ++steps < 5000) {
    troop.crowd.step();
    EXPECT_EQ(troop.crowd.update_surfaces(), 1u);  // also after the step that ends with its sleep
  }
  EXPECT_EQ(troop.crowd.update_surfaces(), 0u);
}

TEST(Crowd, FewerModesMoveAsTheModelLoadedWithFewer) {
  const BasisData data = testing::sample_basis(testing::crowd_strain_model());
  GroupOptions options = group_options("imexv-linear");
  options.modes = 5;
  Crowd crowd = std::move(*Crowd::create());
  const GroupId group = *crowd.add_group(*Model::from_data(data), options);
  const BodyId body = *crowd.add_body(group);
  Body coarse = std::move(
      *Body::create(*Model::from_data(data, {.modes = 5}), "imexv-linear", options.options));
  ASSERT_TRUE(crowd.apply_force(body, 5, {20.0, -5.0, 3.0}, 4));
  ASSERT_TRUE(coarse.apply_force(5, {20.0, -5.0, 3.0}, 4));
  for (int k = 0; k < 100; ++k) {
    crowd.step();
    coarse.step();
  }
  EXPECT_LE((crowd.state(body)->q - coarse.state().q).norm(), 1e-12 * coarse.state().q.norm());
  // Energy is V with the other coordinates at zero.
  EXPECT_NEAR(crowd.energy(body)->total(), coarse.energy().total(),
              1e-12 * coarse.energy().total());
  EXPECT_NEAR(crowd.energy(body)->high_band, coarse.energy().high_band,
              1e-12 * coarse.energy().total());
}

TEST(Crowd, MovingToAnotherGroupKeepsTheCoordinatesBothHave) {
  const Model::Pointer model = crowd_model();
  Troop troop = make_troop(model, group_options("imexv-linear"), 4);
  GroupOptions coarse = group_options("imexv-linear");
  coarse.modes = 5;
  const GroupId few = *troop.crowd.add_group(model, coarse);
  const GroupId single = *troop.crowd.add_group(model, group_options("ep4"));
  ASSERT_TRUE(troop.crowd.set_shown(1, true));
  ASSERT_TRUE(troop.crowd.move_body(1, few));
  EXPECT_TRUE(*troop.crowd.is_awake(1));
  EXPECT_EQ(troop.crowd.state(1)->q, some_q(1).head(5));
  troop.crowd.step();
  EXPECT_EQ(troop.crowd.update_surfaces(), 1u);
  const State state = *troop.crowd.state(1);
  ASSERT_TRUE(troop.crowd.move_body(1, single));
  EXPECT_EQ(troop.crowd.state(1)->p.head(5), state.p);
  EXPECT_EQ(troop.crowd.state(1)->p.tail(4), Eigen::VectorXd::Zero(4));
  EXPECT_EQ(troop.crowd.step().stepped, 4u);
  ASSERT_TRUE(troop.crowd.move_body(1, troop.group));
  EXPECT_EQ(troop.crowd.step().stepped, 4u);
  const GroupId other = *troop.crowd.add_group(crowd_model(), group_options("verlet"));
  EXPECT_FALSE(troop.crowd.move_body(1, other));
}

TEST(Crowd, RemovedBodyIsGoneAndItsNumberIsNotUsedAgain) {
  Troop troop = make_troop(crowd_model(), group_options("imexv-linear"), 3);
  Troop whole = make_troop(crowd_model(), group_options("imexv-linear"), 3);
  ASSERT_TRUE(troop.crowd.remove_body(0));
  EXPECT_FALSE(troop.crowd.wake(0));
  EXPECT_FALSE(troop.crowd.remove_body(0));
  const BodyId added = *troop.crowd.add_body(troop.group);
  EXPECT_EQ(added, 3u);
  EXPECT_EQ(troop.crowd.state(added)->q, Eigen::VectorXd::Zero(kCrowdModes));  // not the old one's
  EXPECT_EQ(troop.crowd.step().stepped, 2u);
  whole.crowd.step();
  EXPECT_EQ(troop.crowd.state(2)->q, whole.crowd.state(2)->q);
}

TEST(Crowd, OneGroupCanStepAlone) {
  const Model::Pointer model = crowd_model();
  Troop troop = make_troop(model, group_options("imexv-linear"), 2);
  const GroupId other = *troop.crowd.add_group(model, group_options("verlet"));
  const BodyId body = *troop.crowd.add_body(other);
  ASSERT_TRUE(troop.crowd.set_state(body, some_q(9), some_p(9)));
  EXPECT_EQ(troop.crowd.step(other)->stepped, 1u);
  EXPECT_EQ(troop.crowd.state(0)->q, some_q(0));
  EXPECT_NE(troop.crowd.state(body)->q, some_q(9));
  EXPECT_FALSE(troop.crowd.step(7));
}

TEST(Crowd, WrongArgumentsAreUsageErrorsThatChangeNothing) {
  const Model::Pointer model = crowd_model();
  Crowd crowd = std::move(*Crowd::create());
  const auto refused = [&](auto change) {
    GroupOptions options;
    change(options);
    const Result<GroupId> group = crowd.add_group(model, options);
    return !group && group.error().kind == ErrorKind::kUsage;
  };
  EXPECT_TRUE(refused([](GroupOptions& o) { o.integrator = "verlot"; }));
  EXPECT_TRUE(refused([](GroupOptions& o) { o.options.step = 0.0; }));
  EXPECT_TRUE(refused([](GroupOptions& o) { o.modes = -1; }));
  EXPECT_TRUE(refused([](GroupOptions& o) { o.modes = kCrowdModes + 1; }));
  EXPECT_TRUE(refused([](GroupOptions& o) {
    o.integrator = "ep4";
    o.modes = 3;
  }));
  EXPECT_TRUE(refused([](GroupOptions& o) { o.sleep.time = -1.0; }));
  EXPECT_TRUE(refused([](GroupOptions& o) { o.sleep.energy = NAN; }));
  EXPECT_FALSE(crowd.add_group(nullptr, {}));
  EXPECT_FALSE(crowd.add_body(0));
  const GroupId group = *crowd.add_group(model, {});
  const BodyId body = *crowd.add_body(group);
  EXPECT_FALSE(crowd.add_body(group + 1));
  EXPECT_FALSE(crowd.apply_force(body + 1, 5, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(crowd.apply_force(body, 99, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(crowd.apply_force(body, 5, {1.0, 0.0, 0.0}, 0));
  EXPECT_FALSE(crowd.apply_force(body, 5, {NAN, 0.0, 0.0}));
  EXPECT_FALSE(crowd.set_state(body, Eigen::VectorXd::Zero(2), Eigen::VectorXd::Zero(2)));
  EXPECT_FALSE(crowd.set_state(body, Eigen::VectorXd::Constant(kCrowdModes, NAN),
                               Eigen::VectorXd::Zero(kCrowdModes)));
  EXPECT_FALSE(*crowd.is_awake(body));
  EXPECT_FALSE(crowd.state(body + 1));
  EXPECT_FALSE(crowd.energy(body + 1));
  EXPECT_FALSE(crowd.surface(body));
}

}  // namespace
}  // namespace tremolo
