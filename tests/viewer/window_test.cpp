// The window, under Xvfb and with a mouse that xdotool moves.
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using testing::fresh_folder;
using testing::ProgramResult;
using testing::run_program;

TEST(ViewerWindow, ADragPullsTheBodyAndTheRecordDoesItAgain) {
  const std::string folder = fresh_folder();
  // The beam fills what the panel leaves of the window; its middle is there.
  const auto [shots, no_window] = testing::drag_in_window(
      folder, "560 290",
      testing::sample_model("beam") + " --load none --measure --record-hand hand.toml");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  // Nothing but the hand acts on it.
  EXPECT_GT(json["hand_work"].get<double>(), 0.0) << result.out << result.err;
  EXPECT_GT(json["largest_displacement"].get<double>(), 1e-5);
  EXPECT_GT(json["mouse_moves"].get<int>(), 0);
  EXPECT_GT(json["steps"].get<int>(), 1000);
  EXPECT_NE(result.err.find("from a mouse's event"), std::string::npos) << result.err;
  const auto file = read_world(folder + "/hand.toml");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->scene.hands.size(), 1U);
  auto world = SceneWorld::create(file->scene);
  ASSERT_TRUE(world) << world.error().message;
  while (world->steps() < json["steps"].get<int>()) ASSERT_TRUE(world->step().empty());
  EXPECT_EQ(world->body(0).contact_sums().hand, json["hand_work"].get<double>());
}

}  // namespace
}  // namespace tremolo
