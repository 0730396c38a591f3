// How deep what is drawn is, and how a body rebounds.
#include "runtime/program/world/surface_depth.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

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

// Nothing of a cube that is as good as rigid vibrates: it rebounds as its points do. The law's e is
// that of a point that comes from far and leaves for far; gravity and the step take a hundredth.
TEST(Rebound, OfARigidBodyIsTheRestitutionOfItsPoints) {
  for (const double restitution : {0.3, 0.7, 1.0}) {
    SceneWorld world = world_of(falling(restitution));
    Rebound rebound;
    rebound.observe(world, 0);
    for (int k = 0; k < 600; ++k) {
      ASSERT_TRUE(world.step().empty());
      rebound.observe(world, 0);
    }
    ASSERT_TRUE(rebound.ratio());
    EXPECT_NEAR(*rebound.ratio(), restitution, 0.02);
  }
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
  EXPECT_NEAR(*rebound.ratio(), 0.7, 0.02);
  EXPECT_NEAR(world.body(0).rigid_state().velocity.z(), 1.7, 0.03);
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

// A sphere between the corners of a face: no point feels it, and the surface is as deep as it is.
TEST(SurfaceDepth, SeesWhatIsBetweenThePoints) {
  Scene scene = falling(0.5);
  scene.gravity = {};
  scene.bodies[0].pose.position = {0.0, 0.0, kHalf};
  scene.bodies[0].contact.points = 4;
  scene.colliders[0].pose.position.z() = -1.0;
  SceneWorld world = world_of(scene);
  SurfaceDepth depth;
  EXPECT_EQ(depth.measure(world, 0), 0.0);
  // The four points that feel are chosen far from each other: one corner of those that do not is
  // put into a small sphere.
  const ContactPoints& points = world.body(0).contact()->points();
  VertexId other = 0;
  while (std::find(points.ids.begin(), points.ids.end(), other) != points.ids.end()) ++other;
  Scene with = scene;
  SceneCollider ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.1};
  ball.pose.position = *world.body(0).position(other) + Vector3d(0.02, 0.0, 0.0);
  with.colliders.push_back(ball);
  SceneWorld touching = world_of(with);
  ASSERT_TRUE(touching.step().empty());
  EXPECT_EQ(touching.penetration_max(0), 0.0);
  EXPECT_NEAR(depth.measure(touching, 0), 0.08, 1e-9);
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
