// Nothing is allocated in a step of a scene, whatever moves: this executable counts its calls of
// malloc, which operator new and Eigen use, where the C library permits it.
#include <atomic>
#include <cstddef>

#include <gtest/gtest.h>

#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/frames/rigged_model.h"

#if defined(__GLIBC__) && !defined(TREMOLO_SANITIZED)
namespace {
std::atomic<long> scene_mallocs = 0;
}
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t size) {
  ++scene_mallocs;
  return __libc_malloc(size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++scene_mallocs;
  return __libc_memalign(alignment, size);
}
}

namespace tremolo {
namespace {

TEST(SceneAllocation, StepsOfAllKindsOfFramesAllocateNothing) {
  Scene scene;
  scene.gravity.times = {0.0, 1.0};
  scene.gravity.values = {{0.0, 0.0, 0.0}, {0.0, 0.0, -9.81}};
  for (const char* method : {"avf", "ep2", "ep4", "newmark", "imexv"})
    for (const FrameKind kind : {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree}) {
      const std::string_view name = method;
      if (kind == FrameKind::kFree && (name == "newmark" || name == "imexv")) continue;
      SceneBody body;
      body.name = std::string(method) + std::to_string(static_cast<int>(kind));
      body.model = kind == FrameKind::kFree ? "free" : "held";
      body.kind = kind;
      body.integrator = method;
      body.options.beta = 1e-3;
      if (kind == FrameKind::kFree) body.spin = {1.0, 5.0, 2.0};
      if (kind == FrameKind::kDriven) {
        KeyframeMotion keys;
        for (int k = 0; k < 5; ++k)
          keys.keys.push_back({0.1 * k, {{0.01 * k * k, 0.0, 0.0}, turn_by({0.1 * k, 0.0, 0.0})}});
        body.motion.parts = {
            keys, SpinMotion{{0, 0, 1}, {0, 0, 0}, 3.0, {}},
            ShakeMotion{{0.01, 0, 0}, 4.0, {.start = 0.0, .end = 2.0, .ramp = 0.1}}};
      }
      SceneLoad load;
      load.signal = {.kind = SignalKind::kSine};
      body.loads = {load};
      scene.bodies.push_back(body);
    }
  SceneBody boned;
  boned.name = boned.model = "boned";
  boned.kind = FrameKind::kDriven;
  boned.bones.resize(2);
  boned.bones[0].name = "a";
  boned.bones[1].name = "b";
  boned.bones[1].parent = "a";
  boned.bones[1].head = boned.bones[1].tail = {0.4, 0.0, 0.0};
  boned.bones[1].motion.parts = {SpinMotion{{0, 0, 1}, {0, 0, 0}, 3.0, {}}};
  scene.bodies.push_back(boned);
  const testing::RiggedBar bar = testing::rigged_bar(6);
  Result<SceneWorld> world = SceneWorld::create(scene, [&bar](const SceneBody& body) {
    if (body.model == "boned") return Result<Model::Pointer>(bar.model);
    return Result<Model::Pointer>(testing::frame_model(6, body.model == "free", 14.0, 120.0));
  });
  ASSERT_TRUE(world) << world.error().message;
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(world->step().empty());
  const long before = scene_mallocs;
  bool good = true;
  for (int k = 0; k < 200; ++k) good = good && world->step().empty();
  const long after = scene_mallocs;
  EXPECT_TRUE(good);
  EXPECT_EQ(after - before, 0);
}

// Bodies that fall onto colliders at rest and in motion, and hands that grab and release.
TEST(SceneAllocation, StepsAmongCollidersAndHandsAllocateNothing) {
  Scene scene;
  scene.step = 1e-3;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  for (const FrameKind kind : {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree}) {
    SceneBody body;
    body.name = "body" + std::to_string(static_cast<int>(kind));
    body.model = kind == FrameKind::kFree ? "free" : "held";
    body.kind = kind;
    if (kind == FrameKind::kFree) body.spin = {1.0, 2.0, 0.0};
    scene.bodies.push_back(body);
    SceneHand hand;
    hand.body = body.name;
    hand.at = "7";
    hand.stiffness = 200.0;
    // A body's first contact of all makes its solver.
    hand.until = 0.002;
    scene.hands.push_back(hand);
    hand.from = 0.1;
    hand.until = 0.3;
    scene.hands.push_back(hand);
  }
  SceneCollider floor;
  floor.name = "floor";
  floor.pose.position.z() = -0.7;
  floor.motion.parts.push_back(ShakeMotion{{0.0, 0.0, 0.02}, 3.0, {0.0, 2.0, 0.1}});
  SceneCollider ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.1};
  ball.pose.position = {0.0, 0.0, 0.6};
  ball.motion.parts.push_back(GlideMotion{{0.0, 0.0, -1.0}, {0.0, 0.4, 0.1}});
  scene.colliders = {floor, ball};
  Result<SceneWorld> world = SceneWorld::create(scene, [](const SceneBody& body) {
    return Result<Model::Pointer>(testing::frame_model(20, body.model == "free", 60.0, 300.0));
  });
  ASSERT_TRUE(world) << world.error().message;
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(world->step().empty());
  const long before = scene_mallocs;
  bool good = true;
  std::size_t events = 0;
  for (int k = 0; k < 500; ++k) {
    good = good && world->step().empty();
    events += world->events().size();
  }
  const long after = scene_mallocs;
  EXPECT_TRUE(good);
  EXPECT_GT(events, 1U);
  EXPECT_EQ(after - before, 0);
}

// After a model's first ray; and steps of what is pinned.
TEST(SceneAllocation, RaysAndPinnedStepsAllocateNothing) {
  ContactBody body = testing::make_framed(testing::frame_model(20, true, 60.0, 300.0),
                                          FrameKind::kFree, {.step = 1e-3});
  ASSERT_TRUE(body.set_contact());
  ASSERT_TRUE(body.set_gravity({0.0, 0.0, -9.81}));
  ASSERT_TRUE(body.pin(VertexId{5}));
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(body.step().converged);
  ASSERT_TRUE(body.pick({0.0, 0.0, 3.0}, {0.0, 0.0, -1.0}));
  const long before = scene_mallocs;
  bool good = true;
  int hits = 0;
  for (int k = 0; k < 300; ++k) {
    good = good && body.step().converged;
    const Eigen::Vector3d to(0.02 * (k % 20) - 0.2, 0.001 * k - 0.15, 0.0);
    const auto hit = body.pick({0.0, 0.0, 3.0}, to - Eigen::Vector3d(0.0, 0.0, 3.0));
    good = good && bool(hit);
    if (hit && *hit) ++hits;
  }
  const long after = scene_mallocs;
  EXPECT_TRUE(good);
  EXPECT_GT(hits, 0);
  EXPECT_EQ(after - before, 0);
}

}  // namespace
}  // namespace tremolo
#endif
