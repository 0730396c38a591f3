// Bodies of tetrahedra in the viewer: surfaces, their numbers, pictures.
#include <fstream>

#include "formats/tets/tets_file.h"
#include "runtime/viewer/tets/tets_scenes.h"
#include "tests/support/meshes/small_tets.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using testing::fresh_folder;

// A bar whose end is held, and a free one above it.
std::string two_bars(const std::string& folder) {
  TetsData data = testing::small_tets();
  EXPECT_TRUE(write_tets(folder + "/held.tets", data));
  data.held.clear();
  EXPECT_TRUE(write_tets(folder + "/free.tets", data));
  std::ofstream(folder + "/bars.toml")
      << "step = 0.01\nduration = 1\ngravity = [0, 0, -9.81]\n[[bodies]]\nname = \"held\"\n"
         "kind = \"tets\"\nmodel = \"held.tets\"\n[[bodies]]\nname = \"free\"\nkind = \"tets\"\n"
         "model = \"free.tets\"\nposition = [0, 0, 0.5]\ndegree = \"linear\"\n[[colliders]]\n"
         "name = \"floor\"\nshape = \"plane\"\nposition = [0, 0, -0.3]\n";
  return folder + "/bars.toml";
}

TEST(TetsView, SheetsAreTheBodiesSurfacesNumberedByTheirDegrees) {
  const std::string file = two_bars(fresh_folder());
  EXPECT_TRUE(is_tets_file(file));
  const Result<TetScene> scene = parse_tets_scene(testing::slurp(file), file);
  ASSERT_TRUE(scene) << scene.error().message;
  Result<TetsScenes> scenes = TetsScenes::create(*scene, true);
  ASSERT_TRUE(scenes) << scenes.error().message;
  ASSERT_EQ(scenes->sheets().size(), 2U);
  EXPECT_EQ(scenes->sheets()[1].name, "free");
  ASSERT_EQ(scenes->solids().size(), 1U);
  EXPECT_EQ(scenes->pose(0).position.z(), -0.3);
  SheetNow now, later;
  scenes->place(1, now);
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(scenes->step());
  EXPECT_NEAR(scenes->time(), 0.1, 1e-12);
  scenes->place(1, later);
  // It falls freely, by bdf2 whose first step is implicit Euler's, and its edges stay linear.
  ASSERT_EQ(now.positions.size(), later.positions.size());
  for (std::size_t k = 2; k < now.positions.size(); k += 3)
    EXPECT_NEAR(now.positions[k] - later.positions[k], 0.5 * 9.81 * 0.01, 0.005);
  ASSERT_EQ(later.numbers.size(), 4U);
  EXPECT_EQ(later.numbers[0], 0.0F);
  ASSERT_TRUE(scenes->begin_again());
  scenes->place(1, later);
  EXPECT_EQ(later.positions, now.positions);
}

TEST(TetsView, PicturesAreTakenAndWhatIsOfOtherBodiesIsRefused) {
  const std::string folder = fresh_folder();
  two_bars(folder);
  for (const char* flags : {"--colour stress --offscreen --out a", "--record-hand a.toml",
                            "--texture a.png", "--offscreen", "--beside bars.toml"}) {
    const testing::ProgramResult result =
        testing::run_program(folder, testing::kView + "bars.toml " + flags);
    EXPECT_EQ(result.code, 2) << flags << result.err;
  }
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const testing::Shots shots = testing::shoot(
      folder, "bars.toml", "--size 120x90 --colour degree --lights 2 --frames 2 --rate 20");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  EXPECT_EQ(shots.json["steps"], 5);
}

}  // namespace
}  // namespace tremolo
