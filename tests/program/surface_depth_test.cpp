// Depth of the drawn surface in an obstacle, and a body's rebound.
#include "runtime/apps/tremolo/world/surface_depth.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/solve/contact_step.h"
#include "tests/support/frames/corner_cube.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kHalf = testing::kCubeHalf;

// A cube that falls on the plane z = 0, on one of its faces.
Scene falling(double restitution) {
  Scene scene;
  scene.step = 1e-3;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneBody body;
  body.name = "cube";
  body.model = "cube";
  body.kind = FrameKind::kFree;
  body.pose.position = {0.0, 0.0, kHalf + 0.2};
  scene.bodies.push_back(body);
  SceneCollider floor;
  floor.name = "floor";
  floor.shape = PlaneShape{};
  floor.friction = 0.0;
  floor.restitution = restitution;
  scene.colliders.push_back(floor);
  return scene;
}

SceneWorld world_of(const Scene& scene, double lowest = 3e4) {
  Result<SceneWorld> world = SceneWorld::create(scene, [lowest](const SceneBody&) {
    return Result<Model::Pointer>(testing::corner_cube(lowest, 3.0 * lowest, 0.0));
  });
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

// Without gravity the speed is constant before and after: the ratio is theirs to rounding. What
// does not vibrate keeps its energy where restitution takes none.
TEST(Rebound, IsTheRatioOfTheSpeedsAfterAndBefore) {
  for (const double restitution : {0.3, 0.7, 1.0}) {
    Scene scene = falling(restitution);
    scene.gravity = {};
    scene.bodies[0].velocity = {0.3, 0.0, -2.0};
    SceneWorld world = world_of(scene);
    Rebound rebound;
    rebound.observe(world, 0);
    for (int k = 0; k < 600; ++k) {
      ASSERT_TRUE(world.step().empty());
      rebound.observe(world, 0);
    }
    ASSERT_TRUE(rebound.ratio());
    const double after = world.body(0).rigid_state().velocity.z();
    EXPECT_GT(after, 0.0);
    EXPECT_NEAR(*rebound.ratio(), after / 2.0, 1e-12);
    if (restitution == 1.0) {
      EXPECT_NEAR(*rebound.ratio(), 1.0, 1e-3);
    }
  }
}

// Under gravity it is that of the time at which the body leaves: a drop that keeps its energy
// returns with the speed that it had.
TEST(Rebound, OfADropThatKeepsItsEnergyIsOne) {
  SceneWorld world = world_of(falling(1.0));
  Rebound rebound;
  rebound.observe(world, 0);
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(world.step().empty());
    rebound.observe(world, 0);
  }
  ASSERT_TRUE(rebound.ratio());
  EXPECT_NEAR(*rebound.ratio(), 1.0, 0.01);  // g h is a two-hundredth of the speed
}

// A collider that moves towards the body counts: the speeds are relative to it.
TEST(Rebound, IsRelativeToTheCollider) {
  Scene scene = falling(0.7);
  scene.gravity = {};
  scene.colliders[0].motion.parts.push_back(GlideMotion{{0.0, 0.0, 1.0}, {}});
  SceneWorld world = world_of(scene);
  Rebound rebound;
  rebound.observe(world, 0);
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(world.step().empty());
    rebound.observe(world, 0);
  }
  ASSERT_TRUE(rebound.ratio());
  EXPECT_NEAR(*rebound.ratio(), world.body(0).rigid_state().velocity.z() - 1.0, 1e-9);
}

TEST(Rebound, IsNoneWithoutACollider) {
  Scene scene = falling(1.0);
  scene.colliders.clear();
  SceneWorld world = world_of(scene);
  Rebound rebound;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(world.step().empty());
    rebound.observe(world, 0);
  }
  EXPECT_FALSE(rebound.ratio());
}

// A corner that is not a contact point flies into a sphere: no point is deep, the surface is as
// deep as the corner.
TEST(SurfaceDepth, SeesWhatIsBetweenThePoints) {
  Scene scene = falling(0.5);
  scene.gravity = {};
  scene.colliders.clear();
  scene.bodies[0].pose.position.setZero();
  scene.bodies[0].contact.points = 4;
  scene.bodies[0].velocity = {1.0, 0.0, 0.0};
  SceneCollider ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.1};
  ball.pose.position = {50.0, 0.0, 0.0};
  scene.colliders.push_back(ball);
  const SceneWorld before = world_of(scene);
  const std::vector<VertexId>& ids = before.body(0).contact()->surface().points->ids;
  VertexId corner = 0;
  const auto feels = [&](VertexId id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  while (feels(corner) || before.body(0).position(corner)->x() < 0.0) ++corner;
  scene.colliders[0].pose.position = *before.body(0).position(corner) + Vector3d(0.27, 0.0, 0.0);
  SceneWorld world = world_of(scene);
  SurfaceDepth depth;
  EXPECT_EQ(depth.measure(world, 0), 0.0);
  // After a quarter of a second the corner is 2 cm from the middle of the sphere.
  for (int k = 0; k < 250; ++k) ASSERT_TRUE(world.step().empty());
  EXPECT_EQ(world.penetration_max(0), 0.0);
  EXPECT_NEAR(depth.measure(world, 0), 0.08, 1e-9);
}

// Two cubes with shapes of their own: the corner of one that is inside the other's box.
TEST(SurfaceDepth, SeesOtherBodies) {
  Scene scene = falling(0.5);
  scene.gravity = {};
  scene.colliders.clear();
  scene.bodies[0].contact.shape = BoxShape{Vector3d::Constant(kHalf)};
  scene.bodies[0].pose.position.setZero();
  SceneBody other = scene.bodies[0];
  other.name = "other";
  other.pose.position = {2.0 * kHalf - 0.003, 0.3, 0.2};
  scene.bodies.push_back(other);
  const SceneWorld world = world_of(scene);
  SurfaceDepth depth;
  EXPECT_NEAR(depth.measure(world, 0), 0.003, 1e-12);
  EXPECT_NEAR(depth.measure(world, 1), 0.003, 1e-12);
  Scene joined = scene;
  SceneJoint joint;
  joint.body = "cube";
  joint.to = "other";
  joint.at = "7";
  joined.joints.push_back(joint);
  EXPECT_EQ(depth.measure(world_of(joined), 0), 0.0) << "they pass through each other";
}

}  // namespace
}  // namespace tremolo
