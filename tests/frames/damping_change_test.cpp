// Damping that changes while a body runs: the energy balance stays closed, and the new damping
// acts.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/tremolo.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

struct Setting {
  std::string method;
  FrameKind frame = FrameKind::kFixed;
  double nonlinearity = 0.3;
  bool loaded = false;
};

ContactBody body_of(const Setting& s, double alpha, double beta) {
  const auto model =
      testing::frame_model(6, s.frame == FrameKind::kFree, 30.0, 400.0, s.nonlinearity);
  IntegratorOptions options;
  options.step = 1e-3;
  options.alpha = alpha;
  options.beta = beta;
  ContactBody body = testing::make_framed(model, s.frame, options, s.method);
  if (s.loaded) {
    const Signal sine{.kind = SignalKind::kSine, .frequency = 3.0};
    EXPECT_TRUE(body.add_load(sine, 5, {20.0, -15.0, 30.0}));
  }
  if (s.frame == FrameKind::kFree) {
    EXPECT_TRUE(body.set_motion({1.0, 0.0, 0.0}, {2.0, 1.0, 3.0}));
  }
  EXPECT_TRUE(body.apply_force(5, {30.0, 20.0, -50.0}, 40));
  return body;
}

// Every method of the energy-preserving family balances to rounding at every time, whatever the
// damping, also from none to some and back.
TEST(DampingChange, AccountsStayClosed) {
  for (const char* method : {"avf", "ep2", "ep4"})
    for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree})
      for (const double nonlinearity : {0.0, 0.3, 2.0})
        for (const bool loaded : {false, true}) {
          const Setting setting{method, frame, nonlinearity, loaded};
          SCOPED_TRACE(std::string(method) + " frame " + std::to_string(static_cast<int>(frame)) +
                       (loaded ? " loaded" : ""));
          ContactBody body = body_of(setting, 0.0, 0.0);
          const double start = body.energy().total();
          double most = start, worst = 0.0;
          for (int k = 0; k < 400; ++k) {
            if (k % 50 == 25) {
              const double much = k / 50 % 3;
              ASSERT_TRUE(body.set_damping(2.0 * much, 1e-3 * much));
            }
            if (frame == FrameKind::kDriven) {
              const double t = body.time();
              ASSERT_TRUE(body.move_to({{0.02 * std::sin(9.0 * t), 0.0, 0.0}, turn_by({0, 0, t})}));
            }
            ASSERT_TRUE(body.step().converged);
            const double energy = body.energy().total();
            most = std::max({most, energy, std::abs(body.sums().work)});
            worst = std::max(worst,
                             std::abs(energy - start - body.sums().work + body.sums().dissipated));
          }
          EXPECT_GT(body.sums().dissipated, 0.0);
          // 400 steps, each closed to rounding.
          EXPECT_LT(worst, 1e-12 * most);
        }
}

// A run whose damping is set to what it is from the start has the bits of one that has it.
TEST(DampingChange, IsTheDampingOfABodyThatHasItFromTheStart) {
  for (const std::string_view method : integrator_names()) {
    const Setting setting{std::string(method)};
    ContactBody had = body_of(setting, 0.5, 1e-3), got = body_of(setting, 0.0, 0.0);
    ASSERT_TRUE(got.set_damping(0.5, 1e-3));
    EXPECT_EQ(got.options().alpha, 0.5);
    EXPECT_EQ(got.options().beta, 1e-3);
    for (int k = 0; k < 100; ++k) {
      (void)had.step();
      (void)got.step();
    }
    EXPECT_EQ(had.state().q, got.state().q) << method;
    EXPECT_EQ(had.sums().dissipated, got.sums().dissipated) << method;
  }
}

// In the middle of a motion: the state of other methods is kept, so that the orbit is that of small
// steps to the method's order. rk4 with a tenth of the step is the truth.
TEST(DampingChange, IsOfTheMethodsOrder) {
  const auto end = [](const std::string& method, double step) {
    const auto model = testing::frame_model(4, false, 20.0, 60.0, 0.3);
    IntegratorOptions options;
    options.step = step;
    options.tolerance = 1e-12;
    ContactBody body = testing::make_framed(model, FrameKind::kFixed, options, method);
    EXPECT_TRUE(
        body.set_state(Eigen::VectorXd::LinSpaced(4, 0.02, 0.01), Eigen::VectorXd::Zero(4)));
    const Signal sine{.kind = SignalKind::kSine, .frequency = 3.0};
    EXPECT_TRUE(body.add_load(sine, 5, {1.0, -2.0, 1.0}));
    const auto steps = std::llround(0.4 / step);
    for (int k = 0; k < steps; ++k) {
      if (k == steps / 2) {
        EXPECT_TRUE(body.set_damping(3.0, 4e-3));
      }
      EXPECT_TRUE(body.step().converged);
    }
    return body.state().q;
  };
  const Eigen::VectorXd truth = end("rk4", 1e-4);
  const double size = truth.norm();
  for (const char* method : {"avf", "ep2", "ep4", "verlet", "verlet4", "midpoint", "newmark",
                             "imexv", "imexv-adaptive", "imexv-linear", "imexv-coupled", "rk4"}) {
    const double coarse = (end(method, 2e-3) - truth).norm() / size;
    const double fine = (end(method, 1e-3) - truth).norm() / size;
    EXPECT_LT(fine, 0.02) << method;
    // Second order at least: 4, less what the load's part has of other signs.
    EXPECT_GT(coarse / fine, 3.0) << method << " " << coarse;
  }
  // First order against damping, with its merged kicks.
  EXPECT_LT((end("imexv-thesis", 1e-3) - truth).norm() / size, 0.1);
}

TEST(DampingChange, WhatIsNoneIsRefusedAndChangesNothing) {
  ContactBody body = body_of({"ep4"}, 0.1, 1e-3);
  for (const double bad :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(body.set_damping(bad, 1e-3));
    EXPECT_FALSE(body.set_damping(0.1, bad));
  }
  EXPECT_EQ(body.options().alpha, 0.1);
  EXPECT_EQ(body.options().beta, 1e-3);
  EXPECT_TRUE(body.step().converged);
  EXPECT_EQ(tremolo_body_set_damping(nullptr, 0.0, 0.0), TREMOLO_USAGE);
}

// Among colliders, with a hand, and while it sleeps.
TEST(DampingChange, AccountsStayClosedInContactAndSleepersWake) {
  Scene scene;
  scene.step = 2e-3;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneBody stone;
  stone.name = "stone";
  stone.kind = FrameKind::kFree;
  stone.model = "free";
  stone.options.beta = 5e-3;
  stone.pose = {{0.0, 0.0, 0.5}, turn_by({0.3, 0.2, 0.0})};
  scene.bodies = {stone};
  SceneCollider floor;
  floor.name = "floor";
  floor.restitution = 0.2;
  floor.pose.position.z() = -0.1;
  scene.colliders = {floor};
  Result<SceneWorld> world = SceneWorld::create(scene, [](const SceneBody&) {
    return Result<Model::Pointer>(testing::frame_model(5, true, 60.0, 300.0, 0.3, 3));
  });
  ASSERT_TRUE(world) << world.error().message;
  double most = 0.0, worst = 0.0;
  int k = 0;
  for (; k < 20'000 && !world->asleep(0); ++k) {
    if (k % 100 == 40 && k < 1'000) {
      ASSERT_TRUE(world->body(0).set_damping(k % 300 == 40 ? 1.0 : 0.0, 1e-3 * (k / 100 % 3)));
    }
    if (k == 1'000) {
      ASSERT_TRUE(world->body(0).set_damping(0.0, 5e-3));
    }
    ASSERT_TRUE(world->step().empty()) << k;
    const EnergyAccount account = world->account(0);
    most = std::max({most, account.total(), std::abs(account.gravity)});
    worst = std::max(worst, std::abs(account.remainder()));
  }
  // Contact is solved to 1e-10 of the momenta in a step.
  EXPECT_LT(worst, 1e-8 * most);
  ASSERT_TRUE(world->asleep(0));
  (void)world->step();
  EXPECT_TRUE(world->asleep(0));
  ASSERT_TRUE(world->body(0).set_damping(0.0, 4e-3));
  (void)world->step();
  EXPECT_FALSE(world->asleep(0));
}

// In a scene each value holds from its time on, as if it were set then.
TEST(DampingChange, ComesFromTheScene) {
  Scene scene;
  scene.step = 1e-3;
  SceneBody stone;
  stone.name = "stone";
  stone.kind = FrameKind::kFree;
  stone.model = "free";
  stone.spin = {1.0, 2.0, 3.0};
  scene.bodies = {stone};
  Scene changing = scene;
  changing.bodies[0].alphas = {{0.0, 0.5}, {0.05, 2.0}};
  changing.bodies[0].betas = {{0.02, 1e-3}, {0.0301, 0.0}};
  const ModelSource source = [](const SceneBody&) {
    return Result<Model::Pointer>(testing::frame_model(5, true, 60.0, 300.0, 0.3, 3));
  };
  Result<SceneWorld> by_hand = SceneWorld::create(scene, source);
  Result<SceneWorld> by_scene = SceneWorld::create(changing, source);
  ASSERT_TRUE(by_hand && by_scene);
  for (SceneWorld* world : {&*by_hand, &*by_scene}) {
    ASSERT_TRUE(world->body(0).apply_force(5, {20.0, 0.0, 10.0}, 10));
  }
  for (int k = 0; k < 100; ++k) {
    const double alpha = k < 50 ? 0.5 : 2.0, beta = k >= 20 && k < 31 ? 1e-3 : 0.0;
    ASSERT_TRUE(by_hand->body(0).set_damping(alpha, beta));
    (void)by_hand->step();
    (void)by_scene->step();
    ASSERT_EQ(by_hand->body(0).state().q, by_scene->body(0).state().q) << k;
  }
  EXPECT_LT(std::abs(by_scene->account(0).remainder()), 1e-12 * by_scene->account(0).total());
}

}  // namespace
}  // namespace tremolo
