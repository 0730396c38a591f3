// Cloth in the viewer: rays, hands, pictures, the window.
#include <fstream>

#include "runtime/viewer/cloth/cloth_scenes.h"
#include "runtime/viewer/picture/png_file.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::fresh_folder;
using testing::ProgramResult;
using testing::run_program;

// A level square of 1 m in z = 1 on its two far corners.
const std::string kSquare =
    "duration = 60\nstep = 0.016666666667\ngravity = [0, 0, -9.81]\n[[cloths]]\nname = \"square\"\n"
    "columns = 11\nrows = 11\ncorner = [-0.5, -0.5, 1]\npins = \"corners\"\n";

Result<ClothScenes> two_squares() {
  Result<ClothFile> file = parse_cloths(kSquare, "square.toml");
  if (!file) return file.error();
  return ClothScenes::create({*file, *file});
}

TEST(ClothView, ARayTakesTheNearestParticleAndTheHandMovesIt) {
  Result<ClothScenes> scenes = two_squares();
  ASSERT_TRUE(scenes) << scenes.error().message;
  EXPECT_FALSE(scenes->take({Vector3d(0.0, 0.7, 3.0), -Vector3d::UnitZ()}));
  EXPECT_FALSE(scenes->take({Vector3d(0.0, 0.0, 0.5), -Vector3d::UnitZ()}));
  ASSERT_TRUE(scenes->take({Vector3d(0.22, -0.28, 3.0), -Vector3d::UnitZ()}));
  const Eigen::Index particle = 3 * (2 * 11 + 7);
  EXPECT_LE((*scenes->hand() - Vector3d(0.2, -0.3, 1.0)).norm(), 1e-12);
  const Vector3d goal(0.25, -0.25, 1.3);
  scenes->move_to(goal);
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(scenes->step());
  const auto place = [&] {
    return Vector3d(scenes->shown()[0].world.positions(0).segment<3>(particle));
  };
  EXPECT_LE((place() - goal).norm(), 1e-12);
  scenes->let_go();
  EXPECT_FALSE(scenes->hand());
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(scenes->step());
  EXPECT_GT((place() - goal).norm(), 1e-2);
}

TEST(ClothView, TheSecondSceneStandsBesideTheFirstAndIsTakenThere) {
  Result<ClothScenes> scenes = two_squares();
  ASSERT_TRUE(scenes) << scenes.error().message;
  const Vector3d aside = scenes->shown()[1].aside;
  EXPECT_GT(aside.x(), 1.0);
  ASSERT_TRUE(scenes->take({aside + Vector3d(0.0, 0.0, 3.0), -Vector3d::UnitZ()}));
  EXPECT_LE((*scenes->hand() - aside - Vector3d(0.0, 0.0, 1.0)).norm(), 1e-12);
  scenes->move_to(aside + Vector3d(0.0, 0.0, 1.2));
  ASSERT_TRUE(scenes->step());
  EXPECT_NEAR(scenes->shown()[1].world.positions(0)[3 * 60 + 2], 1.2, 1e-12);
  EXPECT_LT(scenes->shown()[0].world.positions(0)[3 * 60 + 2], 1.0);
  ASSERT_TRUE(scenes->begin_again());
  EXPECT_EQ(scenes->time(), 0.0);
  EXPECT_FALSE(scenes->hand());
}

TEST(ClothView, ASheetIsDrawnWhereItIs) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  // From straight above, framed at rest: as broad as high, and nothing else but white.
  const testing::Shots shots =
      testing::shoot(folder, "square.toml",
                     "--size 200x200 --camera 0,89.9 --background white --paint '#400000' "
                     "--lights 2 --frames 2 --rate 5");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  EXPECT_NEAR(shots.json["frames"][1]["time"].get<double>(), 0.2, 1e-6);
  const Result<Picture> picture = read_png(shots.json["frames"][0]["file"]);
  ASSERT_TRUE(picture);
  int low[2] = {200, 200}, high[2] = {-1, -1}, count = 0;
  for (int i = 0; i < 200 * 200; ++i) {
    if (picture->pixels[static_cast<std::size_t>(3 * i + 2)] > 128) continue;
    ++count;
    const int at[2] = {i % 200, i / 200};
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  const int width = high[0] - low[0] + 1, height = high[1] - low[1] + 1;
  EXPECT_GT(width, 120);
  EXPECT_NEAR(width, height, 2);
  EXPECT_NEAR(count, width * height, 0.01 * width * height);
  EXPECT_NEAR(low[0] + high[0], 199, 2);
}

TEST(ClothView, FlagsThatAreOfBodiesAreRefused) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  for (const char* flags :
       {"--colour stress --offscreen --out a", "--record-hand a.toml", "--texture a.png",
        "--offscreen", "--video a.mp4", "--beside square.toml --step 0 --offscreen --out a"}) {
    const ProgramResult result = run_program(folder, testing::kView + "square.toml " + flags);
    EXPECT_TRUE(result.code == 2 || result.code == 3) << flags << result.err;
  }
}

TEST(ClothView, ADragInTheWindowPullsAParticle) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  const auto [shots, no_window] =
      testing::drag_in_window(folder, "390 290", "square.toml --camera 0,80 --paused");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  EXPECT_EQ(json["pulls"], 1) << result.out;
  EXPECT_GT(json["longest_pull"].get<double>(), 0.02) << result.out;
  EXPECT_GT(json["pictures"].get<int>(), 3);
}

}  // namespace
}  // namespace tremolo
