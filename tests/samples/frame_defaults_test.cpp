// Every kind of frame with nothing but its defaults, on every sample model: fixed under gravity,
// driven through a shake and a rotation, and the free bases thrown.
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

constexpr double kBalance = 1e-11;  // of the largest energy: exact up to the solves' rounding

SceneBody sample_body(const std::string& name, FrameKind kind) {
  SceneBody body;
  body.name = name;
  body.model = std::string(TREMOLO_MODEL_DIR "/") + name + ".tremolo";
  body.kind = kind;
  return body;
}

// 10 s; the largest deformation over the size, and the largest remainder over the largest energy.
void run_scene(const Scene& scene, const char* what) {
  Result<SceneWorld> world = SceneWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  const Momenta start = world->momenta(0);
  double most = 0.0, remainder = 0.0;
  for (int k = 0; k < 3333; ++k) {
    ASSERT_TRUE(world->step().empty()) << what << " at step " << k;
    const EnergyAccount account = world->account(0);
    most = std::max(most, account.total());
    remainder = std::max(remainder, std::abs(account.remainder()));
  }
  const Body& body = world->body(0);
  std::printf("%-10s %-7s %.3g J, balance %.1e\n", world->name(0).c_str(), what, most,
              remainder / most);
  EXPECT_TRUE(body.state().q.allFinite());
  EXPECT_GT(most, 0.0);
  EXPECT_LE(remainder, kBalance * most) << what;
  if (body.frame() != FrameKind::kFree) return;
  const Momenta end = world->momenta(0);
  EXPECT_LE((end.linear - start.linear).norm(), 1e-12 * start.linear.norm());
  EXPECT_LE((end.angular - start.angular).norm(), 1e-12 * start.angular.norm());
}

class HeldFrames : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Six, HeldFrames,
                         ::testing::Values("beam", "basket", "bridge", "horse", "tower", "heart"),
                         [](const auto& sample) { return std::string(sample.param); });

TEST_P(HeldFrames, KeepTheirBalance) {
  Scene scene;
  scene.bodies = {sample_body(GetParam(), FrameKind::kFixed)};
  scene.gravity.values = {{0.0, 0.0, -1.0}};
  run_scene(scene, "fixed");
  scene.bodies = {sample_body(GetParam(), FrameKind::kDriven)};
  scene.bodies[0].motion.parts = {
      ShakeMotion{{0.005, 0.003, 0.0}, 2.0, {.start = 0.0, .end = 4.0, .ramp = 0.5}},
      SpinMotion{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 2.0, {.start = 0.5, .end = 5.0, .ramp = 1.0}}};
  run_scene(scene, "driven");
}

TEST(FreeFrames, KeepTheirBalance) {
  Scene scene;
  scene.bodies = {sample_body("horse-free", FrameKind::kFree)};
  scene.bodies[0].velocity = {1.0, 0.0, 2.0};
  scene.bodies[0].spin = {2.0, 0.3, 9.0};
  run_scene(scene, "free");
}

}  // namespace
}  // namespace tremolo
