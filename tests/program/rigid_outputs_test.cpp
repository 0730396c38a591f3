// Columns and sounds of worlds in which some bodies are rigid.
#include <utility>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/output/world_sound.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "tests/support/frames/corner_cube.h"

namespace tremolo {
namespace {

// A cube that deforms, unless it is left out, and a rigid sphere far from it.
SceneWorld world_of(bool cube, const std::vector<std::string>& coordinates) {
  Scene scene;
  scene.step = 1.0 / 48'000.0;
  SceneBody soft;
  soft.name = "cube";
  soft.model = "cube";
  soft.kind = FrameKind::kFree;
  soft.columns.coordinates = coordinates;
  if (cube) scene.bodies.push_back(soft);
  SceneBody rigid;
  rigid.name = "ball";
  rigid.kind = FrameKind::kFree;
  rigid.rigid.emplace();
  rigid.rigid->shape = SphereShape{0.1};
  rigid.pose.position.x() = 10.0;
  rigid.columns.coordinates = coordinates;
  scene.bodies.push_back(rigid);
  Result<SceneWorld> world = SceneWorld::create(scene, [](const SceneBody& body) {
    return body.rigid ? load_scene_model(body)
                      : Result<Model::Pointer>(testing::corner_cube(3e3, 9e3, 0.0));
  });
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

TEST(RigidOutputs, CoordinatesAreThoseOfBodiesThatHaveSome) {
  for (const char* which : {"all", "0-2", "1"}) {
    EXPECT_TRUE(check_columns(world_of(true, {which}))) << which;
    const Status alone = check_columns(world_of(false, {which}));
    ASSERT_FALSE(alone) << which;
    EXPECT_NE(alone.error().message.find("no body has any"), std::string::npos);
  }
  EXPECT_TRUE(check_columns(world_of(false, {})));
  EXPECT_FALSE(check_columns(world_of(true, {"0-99"})));
}

TEST(RigidOutputs, SoundIsThatOfBodiesThatDeform) {
  const SceneWorld both = world_of(true, {});
  const Result<WorldSound> sound = WorldSound::create("near:0,0,1", both, 1);
  ASSERT_TRUE(sound) << sound.error().message;
  EXPECT_FALSE(sound->leaves_out(0));
  EXPECT_TRUE(sound->leaves_out(1));
  EXPECT_FALSE(WorldSound::create("ball:near:0,0,1", both, 1));
  const Result<WorldSound> alone = WorldSound::create("near:0,0,1", world_of(false, {}), 1);
  ASSERT_FALSE(alone);
  EXPECT_NE(alone.error().message.find("no body of the scene has modes"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
