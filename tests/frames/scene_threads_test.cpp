// Worlds that several threads step: no bit depends on how many.
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/state_stream.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

Result<Model::Pointer> model_of_many(const SceneBody& body) {
  const bool free = body.model == "free";
  return testing::frame_model(4, free, 60.0, 300.0, 0.2, free ? 3 : 4);
}

// Rows of free bodies that fall on a floor; in each row the first two hit each other, the next two
// are joined, and the last is alone. Beside them a driven and a fixed body.
Scene many_islands() {
  Scene scene;
  scene.step = 2e-3;
  scene.duration = 1.0;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  for (int row = 0; row < 5; ++row)
    for (int k = 0; k < 5; ++k) {
      SceneBody body;
      body.name = "body" + std::to_string(5 * row + k);
      body.kind = FrameKind::kFree;
      body.model = "free";
      body.options.beta = 1e-3;
      body.pose = {{1.3 * k, 4.0 * row, 0.6 + 0.05 * k}, turn_by({0.2 * row, 0.1 * k, 0.0})};
      body.velocity = {k == 0 ? 2.0 : 0.0, 0.0, 0.0};
      body.spin = {0.5, 0.3 * row, -0.2 * k};
      body.contact.shape = BoxShape{{0.4, 0.25, 0.15}};
      scene.bodies.push_back(body);
    }
  for (int row = 0; row < 5; ++row) {
    SceneJoint joint;
    joint.body = "body" + std::to_string(5 * row + 2);
    joint.to = "body" + std::to_string(5 * row + 3);
    joint.at = "4";
    scene.joints.push_back(joint);
  }
  SceneBody shaken;
  shaken.name = "shaken";
  shaken.kind = FrameKind::kDriven;
  shaken.model = "held";
  shaken.pose.position = {-3.0, 0.0, 1.0};
  shaken.motion.parts = {ShakeMotion{{0.0, 0.05, 0.02}, 2.0, {0.0, 5.0, 0.2}}};
  scene.bodies.push_back(shaken);
  SceneCollider floor;
  floor.name = "floor";
  floor.restitution = 0.3;
  scene.colliders = {floor};
  return scene;
}

SceneWorld world_with(const Scene& scene, unsigned threads) {
  Result<SceneWorld> world = SceneWorld::create(scene, model_of_many);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  EXPECT_TRUE(world->set_threads(threads));
  return std::move(*world);
}

TEST(SceneThreads, ChangeNoBit) {
  const Scene scene = many_islands();
  SceneWorld one = world_with(scene, 1);
  std::vector<SceneWorld> others;
  for (const unsigned threads : {2U, 4U}) others.push_back(world_with(scene, threads));
  std::size_t of_bodies = 0, of_colliders = 0;
  for (int k = 0; k < 350; ++k) {
    ASSERT_TRUE(one.step().empty()) << k;
    for (const ContactEvent& event : one.events())
      ++(event.collider == ContactEvent::kNone ? of_bodies : of_colliders);
    for (SceneWorld& other : others) {
      ASSERT_TRUE(other.step().empty()) << k;
      ASSERT_EQ(state_bytes(one), state_bytes(other)) << k;
    }
  }
  // There was work to divide: bodies hit each other, and the floor.
  EXPECT_GT(of_bodies, 4U);
  EXPECT_GT(of_colliders, 20U);
}

TEST(SceneThreads, MayChangeInARunningWorld) {
  const Scene scene = many_islands();
  SceneWorld one = world_with(scene, 1), other = world_with(scene, 3);
  for (int k = 0; k < 150; ++k) {
    if (k == 50 || k == 100) {
      const Status set = other.set_threads(k == 50 ? 1 : 2);
      ASSERT_TRUE(set) << set.error().message;
    }
    (void)one.step();
    (void)other.step();
  }
  EXPECT_EQ(state_bytes(one), state_bytes(other));
}

}  // namespace
}  // namespace tremolo
