// Scenes: bodies that are stepped together, their energy balances, refusals.
#include "runtime/world/scene_world.h"

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/frames/frame_scenes.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Result<Model::Pointer> two_models(const SceneBody& body) {
  return testing::cloud_file(body, 14.0, 120.0);
}

SceneBody shaken_body(const std::string& name) {
  SceneBody body = testing::cloud_body(name, FrameKind::kDriven);
  body.options.beta = 1e-3;
  body.motion.parts.push_back(
      ShakeMotion{{0.02, 0.01, 0.0}, 2.0, {.start = 0.1, .end = 2.0, .ramp = 0.5}});
  body.motion.parts.push_back(SpinMotion{{0, 0, 1}, {0.1, 0, 0}, 3.0, {0.2, 1.0, 0.3}});
  SceneLoad load;
  load.signal = {.kind = SignalKind::kSine};
  body.loads.push_back(load);
  return body;
}

Scene some_scene() {
  Scene scene;
  scene.duration = 1.0;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneBody thrown = testing::cloud_body("thrown", FrameKind::kFree);
  thrown.pose = {{1.0, 2.0, 3.0}, turn_by({0.4, 0.0, 0.2})};
  thrown.velocity = {1.0, 0.0, 4.0};
  thrown.spin = {0.0, 6.0, 1.0};
  scene.bodies = {thrown, shaken_body("shaken"), testing::cloud_body("fixed", FrameKind::kFixed)};
  return scene;
}

SceneWorld world_of(const Scene& scene) {
  Result<SceneWorld> world = SceneWorld::create(scene, two_models);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

std::string why_refused(const Scene& scene) {
  const Result<SceneWorld> world = SceneWorld::create(scene, two_models);
  EXPECT_FALSE(world);
  if (world) return {};
  EXPECT_EQ(world.error().kind, ErrorKind::kContent) << world.error().message;
  return world.error().message;
}

void expect_in(const std::string& text, const std::string& words) {
  EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(SceneWorld, AccountsOfEveryBodyClose) {
  SceneWorld world = world_of(some_scene());
  std::vector<double> most(world.size(), 0.0);
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(world.step().empty());
    for (std::size_t i = 0; i < world.size(); ++i) {
      const EnergyAccount account = world.account(i);
      most[i] = std::max(most[i], account.total());
      ASSERT_LE(std::abs(account.remainder()), 1e-12 * most[i]) << world.name(i) << k;
    }
  }
  const EnergyAccount shaken = world.account(*world.find("shaken"));
  EXPECT_NE(shaken.support, 0.0);
  EXPECT_NE(shaken.load, 0.0);
  EXPECT_LT(shaken.damping, 0.0);
  EXPECT_EQ(world.account(*world.find("fixed")).support, 0.0);
  EXPECT_NEAR(world.time(), 1.8, 1e-12);
}

TEST(SceneWorld, OrderOfBodiesChangesNoBit) {
  const Scene scene = some_scene();
  Scene turned = scene;
  std::reverse(turned.bodies.begin(), turned.bodies.end());
  SceneWorld one = world_of(scene), other = world_of(turned);
  for (int k = 0; k < 300; ++k) {
    one.step();
    other.step();
  }
  for (std::size_t i = 0; i < one.size(); ++i) {
    const std::size_t j = *other.find(one.name(i));
    EXPECT_EQ(one.body(i).state().q, other.body(j).state().q) << one.name(i);
    EXPECT_EQ(one.body(i).pose().position, other.body(j).pose().position) << one.name(i);
    EXPECT_EQ(one.account(i).remainder(), other.account(j).remainder()) << one.name(i);
  }
}

TEST(SceneWorld, BodiesAreWhereTheirMotionSays) {
  const Scene scene = some_scene();
  SceneWorld world = world_of(scene);
  const std::size_t shaken = *world.find("shaken");
  const MotionPath path = *MotionPath::create(scene.bodies[shaken].motion);
  for (int k = 0; k < 300; ++k) {
    world.step();
    ASSERT_EQ(world.body(shaken).pose().position, path.pose(world.time()).position);
  }
}

TEST(SceneWorld, FixedBodyAtAnotherPlaceFeelsGravityAlongItsOwnAxes) {
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneBody turned = testing::cloud_body("turned", FrameKind::kFixed);
  turned.pose = {{5.0, 0.0, 0.0}, turn_by({M_PI, 0.0, 0.0})};
  scene.bodies = {turned};
  SceneWorld world = world_of(scene);
  ContactBody other =
      testing::make_framed(world.body(0).model().shared_from_this(), FrameKind::kFixed, {});
  ASSERT_TRUE(other.set_gravity({0.0, 0.0, 9.81}));
  for (int k = 0; k < 100; ++k) {
    world.step();
    ASSERT_TRUE(other.step().converged);
  }
  EXPECT_LE((world.body(0).state().q - other.state().q).norm(), 1e-12 * other.state().q.norm());
}

TEST(SceneWorld, SettledBodyStaysWhereGravityAndItsLoadHoldIt) {
  Scene scene;
  scene.gravity.values = {{0.0, 1.0, -9.81}};
  SceneBody body = testing::cloud_body("settled", FrameKind::kDriven);
  body.pose.rotation = turn_by({0.3, 0.0, 0.5});
  body.settled = true;
  SceneLoad load;
  load.signal = {.kind = SignalKind::kConstant};
  body.loads = {load};
  scene.bodies = {body};
  SceneWorld world = world_of(scene);
  const Eigen::VectorXd q = world.body(0).state().q;
  EXPECT_GT(q.norm(), 1e-3);
  for (int k = 0; k < 300; ++k) world.step();
  EXPECT_LE((world.body(0).state().q - q).norm(), 1e-8 * q.norm());
}

TEST(SceneWorld, GravityFollowsItsTable) {
  SceneGravity table;
  table.times = {1.0, 2.0};
  table.values = {{0.0, 0.0, -10.0}, {0.0, 4.0, 0.0}};
  EXPECT_EQ(table.at(0.0), Vector3d(0.0, 0.0, -10.0));
  EXPECT_EQ(table.at(1.5), Vector3d(0.0, 2.0, -5.0));
  EXPECT_EQ(table.at(3.0), Vector3d(0.0, 4.0, 0.0));
  Scene scene;
  scene.step = 0.01;
  scene.gravity = table;
  scene.bodies = {testing::cloud_body("falls", FrameKind::kFree)};
  SceneWorld world = world_of(scene);
  for (int k = 0; k < 300; ++k) world.step();
  // The mid-point rule is exact for straight lines.
  const Vector3d fallen = world.body(0).rigid_state().velocity;
  EXPECT_LE((fallen - Vector3d(0.0, 6.0, -15.0)).norm(), 1e-12);
}

TEST(SceneWorld, TeleportedBodyFeelsNothing) {
  Scene scene;
  SceneBody body = testing::cloud_body("moved", FrameKind::kDriven);
  KeyframeMotion keys;
  keys.interpolation = Interpolation::kLinear;
  keys.jumps = JumpRule::kTeleport;
  const auto at = [](double x) {
    return Pose{Vector3d(x, 0.0, 0.0), Eigen::Quaterniond::Identity()};
  };
  keys.keys = {{0.1, at(0.0)}, {0.1, at(7.0)}, {0.2, at(7.0)}};
  body.motion.parts.push_back(keys);
  scene.bodies = {body};
  SceneWorld world = world_of(scene);
  for (int k = 0; k < 60; ++k) world.step();
  EXPECT_EQ(world.body(0).pose().position.x(), 7.0);
  EXPECT_TRUE(world.body(0).state().q.isZero(0.0));
  std::get<KeyframeMotion>(scene.bodies[0].motion.parts[0]).jumps = JumpRule::kRefuse;
  const std::string why = why_refused(scene);
  expect_in(why, "body 'moved': its pose jumps at t = 0.1 s by 7 m");
  expect_in(why, "acceleration of 777778 m/s^2");
  expect_in(why, "teleport");
}

TEST(SceneWorld, MomentaOfADrivenBodyAreThoseOfItsPoints) {
  const testing::PointCloud cloud = testing::random_cloud(5, false, 4);
  SceneWorld world = world_of(some_scene());
  const std::size_t shaken = *world.find("shaken");
  for (int k = 0; k < 200; ++k) world.step();
  const MotionPath path = *MotionPath::create(some_scene().bodies[shaken].motion);
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  const State& state = world.body(shaken).state();
  const double t = world.time(), bit = 1e-5;
  for (std::size_t k = 0; k < cloud.masses.size(); ++k) {
    const Eigen::MatrixXd phi = cloud.basis.middleRows(3 * static_cast<Eigen::Index>(k), 3);
    const auto place = [&](double s) {
      return path.pose(t + s) * Vector3d(cloud.places[k] + phi * (state.q + s * state.p));
    };
    const Vector3d momentum = cloud.masses[k] * (place(bit) - place(-bit)) / (2.0 * bit);
    linear += momentum;
    angular += place(0.0).cross(momentum);
  }
  // The frame's velocities are given as differences over two steps.
  const Momenta reported = world.momenta(shaken);
  EXPECT_LE((reported.linear - linear).norm(), 1e-3 * linear.norm());
  EXPECT_LE((reported.angular - angular).norm(), 1e-3 * angular.norm());
}

TEST(SceneWorld, BodyThatFailsStandsStillAndTheOthersGoOn) {
  SceneWorld world = world_of(some_scene());
  world.step();
  const std::size_t thrown = *world.find("thrown"), shaken = *world.find("shaken");
  ASSERT_TRUE(world.body(thrown).apply_force(5, {1e150, 0.0, 0.0}));
  const Eigen::VectorXd before = world.body(thrown).state().q;
  const auto failures = world.step();
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].body, thrown);
  EXPECT_TRUE(world.failed(thrown));
  EXPECT_EQ(world.body(thrown).state().q, before);
  EXPECT_TRUE(world.step().empty());
  EXPECT_EQ(world.body(thrown).counts().steps, 1);
  EXPECT_EQ(world.body(shaken).counts().steps, 3);
}

TEST(SceneWorld, RefusesWhatMakesNoScene) {
  Scene scene = some_scene();
  scene.bodies[1].name = "thrown";
  expect_in(why_refused(scene), "two bodies are named 'thrown'");
  scene = some_scene();
  scene.bodies[0].pose.position.x() = NAN;
  expect_in(why_refused(scene), "body 'thrown': the pose is not finite");
  scene = some_scene();
  scene.bodies[0].pose.rotation.coeffs() *= 2.0;
  expect_in(why_refused(scene), "quaternion is of length 2");
  scene = some_scene();
  scene.bodies[2].motion = scene.bodies[1].motion;
  expect_in(why_refused(scene), "body 'fixed': a motion moves a driven body only");
  scene = some_scene();
  scene.bodies[1].velocity.x() = 1.0;
  expect_in(why_refused(scene), "body 'shaken': velocity and spin are those of a free body");
  scene = some_scene();
  scene.bodies[0].settled = true;
  expect_in(why_refused(scene), "body 'thrown': a free body falls");
  scene = some_scene();
  scene.step = 0.0;
  expect_in(why_refused(scene), "step must be positive");
  scene = some_scene();
  scene.bodies[1].acceleration_limit = 1.0;
  expect_in(why_refused(scene), "above its acceleration-limit of 1 m/s^2");
  scene = some_scene();
  scene.bodies.clear();
  expect_in(why_refused(scene), "no body");
}

TEST(SceneWorld, MissingBasisFileNamesItsCommand) {
  Scene scene;
  scene.bodies = {testing::cloud_body("thrown", FrameKind::kFree)};
  scene.bodies[0].model = "nowhere/thing.tremolo";
  const Result<SceneWorld> usual = SceneWorld::create(scene);
  ASSERT_FALSE(usual);
  expect_in(usual.error().message,
            "body 'thrown': nowhere/thing.tremolo: there is no such basis file; make it with "
            "`tremolo-precompute MESH -o nowhere/thing.tremolo --fix none`");
  scene.bodies[0].made_by = "./demo";
  expect_in(SceneWorld::create(scene).error().message, "make it with `./demo`");
}

}  // namespace
}  // namespace tremolo
