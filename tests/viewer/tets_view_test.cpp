// Bodies of tetrahedra in the viewer: surfaces, their numbers, pictures.
#include <algorithm>
#include <fstream>

#include "formats/tets/tets_file.h"
#include "runtime/apps/view/tets/tets_scenes.h"
#include "tests/support/meshes/small_tets.h"
#include "tests/viewer/masks.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::fresh_folder;

// Writes a scene of a bar whose end is fixed and of a free one half a metre above it; returns its
// name. world: its first lines; held, free: further lines of the two.
std::string write_bars(const std::string& folder, TetsData data, const std::string& world,
                       const std::string& held, const std::string& free) {
  EXPECT_TRUE(write_tets(folder + "/held.tets", data));
  data.held.clear();
  EXPECT_TRUE(write_tets(folder + "/free.tets", data));
  std::ofstream(folder + "/bars.toml")
      << world << "[[bodies]]\nname = \"held\"\nkind = \"tets\"\nmodel = \"held.tets\"\n"
      << held << "[[bodies]]\nname = \"free\"\nkind = \"tets\"\nmodel = \"free.tets\"\n"
      << "position = [0, 0, 0.5]\n"
      << free;
  return folder + "/bars.toml";
}

// Without weight, with surfaces that are drawn.
std::string two_whole_bars(const std::string& folder) {
  TetsData data = testing::small_tets();
  data.surface = testing::drawn_boundary(data.mesh);
  return write_bars(folder, data, "step = 0.01\nduration = 60\ngravity = [0, 0, 0]\n",
                    "beta = 0.02\n", "");
}

// Above a floor.
std::string two_bars(const std::string& folder) {
  return write_bars(folder, testing::small_tets(),
                    "step = 0.01\nduration = 1\ngravity = [0, 0, -9.81]\n", "",
                    "degree = \"linear\"\n[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n"
                    "position = [0, 0, -0.3]\n");
}

Result<TetsScenes> scenes_of(const std::string& file) {
  Result<TetScene> scene = parse_tets_scene(testing::slurp(file), file);
  if (!scene) return scene.error();
  return TetsScenes::create(std::move(*scene));
}

TEST(TetsView, SheetsAreTheBodiesSurfacesNumberedByTheirDegrees) {
  const std::string file = two_bars(fresh_folder());
  EXPECT_TRUE(is_scene_of(SceneKind::kTets, file));
  const Result<TetScene> scene = parse_tets_scene(testing::slurp(file), file);
  ASSERT_TRUE(scene) << scene.error().message;
  Result<TetsScenes> scenes = TetsScenes::create(*scene);
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
  ASSERT_EQ(later.degrees.size(), 4U);
  EXPECT_EQ(later.degrees[0], 0.0F);
  ASSERT_TRUE(scenes->begin_again());
  scenes->place(1, later);
  EXPECT_EQ(later.positions, now.positions);
}

TEST(TetsView, ARayTakesTheNearestVertexFromEverySide) {
  Result<TetsScenes> scenes = scenes_of(two_whole_bars(fresh_folder()));
  ASSERT_TRUE(scenes) << scenes.error().message;
  const Vector3d size(0.2, 0.1, 0.1), above(0.0, 0.0, 0.5);
  int tried = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sides(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
    const Vector3d place = sides.cwiseProduct(size) + above;
    for (int axis = 0; axis < 3; ++axis) {
      // A centimetre inwards along both of the face's edges, seen from the face's side.
      const Vector3d inwards = 0.01 * (Vector3d::Ones() - 2.0 * sides);
      Vector3d met = place + inwards;
      met[axis] = place[axis];
      const Vector3d out = (2.0 * sides[axis] - 1.0) * Vector3d::Unit(axis);
      // From below the other bar hides it, whose left end cannot be taken.
      double away = 2.0;
      if (out.z() < -0.5) {
        EXPECT_EQ(scenes->take({met + away * out, -out}), sides.x() > 0.5) << corner;
        if (scenes->hand()) {
          EXPECT_LE(scenes->hand()->z(), 0.1) << corner;
        }
        away = 0.2;
      }
      ASSERT_TRUE(scenes->take({met + away * out, -out})) << corner << axis;
      EXPECT_LE((*scenes->hand() - place).norm(), 1e-12) << corner << axis;
      EXPECT_LE((*scenes->held() - place).norm(), 1e-12) << corner << axis;
      ++tried;
    }
  }
  EXPECT_EQ(tried, 24);
  // Along the diagonal between a face's triangles, slanted, and past everything.
  EXPECT_TRUE(scenes->take({Vector3d(0.05, 0.05, 3.0), -Vector3d::UnitZ()}));
  EXPECT_TRUE(scenes->take({Vector3d(0.05, -2.0, 0.55), Vector3d::UnitY()}));
  EXPECT_TRUE(scenes->take({Vector3d(1.1, 2.05, 3.55), Vector3d(-1.0, -2.0, -3.0).normalized()}));
  EXPECT_FALSE(scenes->take({Vector3d(0.25, 0.05, 3.0), -Vector3d::UnitZ()}));
  EXPECT_FALSE(scenes->take({Vector3d(0.05, 0.05, 3.0), Vector3d::UnitZ()}));
  EXPECT_FALSE(scenes->hand());
}

TEST(TetsView, AHandPullsAHeldBarFourFifthsOfItsWayAndTakesAFreeOneAlong) {
  Result<TetsScenes> scenes = scenes_of(two_whole_bars(fresh_folder()));
  ASSERT_TRUE(scenes) << scenes.error().message;
  // Fixed vertices cannot be pulled.
  EXPECT_FALSE(scenes->take({Vector3d(-1.0, 0.01, 0.01), Vector3d::UnitX()}));
  ASSERT_TRUE(scenes->take({Vector3d(1.0, 0.09, 0.09), -Vector3d::UnitX()}));
  const Vector3d begun = *scenes->held();
  EXPECT_LE((begun - Vector3d(0.2, 0.1, 0.1)).norm(), 1e-12);
  const Vector3d way(0.0, 0.0, 0.002);
  for (int k = 1; k <= 300; ++k) {
    scenes->move_to(begun + std::min(1.0, 0.01 * k) * way);
    ASSERT_TRUE(scenes->step());
  }
  // The spring is measured with quadratic edges; of those that choose, some stay linear here, and
  // the bar is up to half as stiff again: 0.73 of the displacement.
  EXPECT_NEAR((*scenes->held() - begun).z(), 0.8 * way.z(), 0.08 * way.z());
  scenes->let_go();
  for (int k = 0; k < 600; ++k) ASSERT_TRUE(scenes->step());
  ASSERT_TRUE(scenes->take({Vector3d(1.0, 0.09, 0.09), -Vector3d::UnitX()}));
  EXPECT_LE((*scenes->held() - begun).norm(), 1e-5);
  // The free one follows, and swings about the hand with 2 Hz: after four seconds it is there, and
  // rotates a little.
  ASSERT_TRUE(scenes->take({Vector3d(0.1, 0.05, 3.0), -Vector3d::UnitZ()}));
  const Vector3d taken = *scenes->held(), goal = taken + Vector3d(0.0, 0.0, 0.3);
  scenes->move_to(goal);
  for (int k = 0; k < 400; ++k) ASSERT_TRUE(scenes->step());
  EXPECT_LE((*scenes->held() - goal).norm(), 0.01);
  ASSERT_TRUE(scenes->begin_again());
  EXPECT_FALSE(scenes->hand());
}

TEST(TetsView, ADragInTheWindowPullsABar) {
  const std::string folder = fresh_folder();
  two_whole_bars(folder);
  std::ofstream(folder + "/one.toml")
      << "step = 0.01\nduration = 60\ngravity = [0, 0, 0]\n[[bodies]]\nname = \"held\"\n"
         "kind = \"tets\"\nmodel = \"held.tets\"\nbeta = 0.02\n";
  const auto [shots, no_window] =
      testing::drag_in_window(folder, "390 290", "one.toml --camera 0,0");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  EXPECT_EQ(json["pulls"], 1) << result.out;
  EXPECT_GT(json["longest_pull"].get<double>(), 0.01) << result.out;
  EXPECT_EQ(json["trouble"], "") << result.out;
}

TEST(TetsView, PicturesAreTakenAndWhatIsOfOtherBodiesIsRefused) {
  const std::string folder = fresh_folder();
  two_bars(folder);
  for (const char* flags :
       {"--record-hand a.toml", "--offscreen", "--beside bars.toml", "--video a.mp4"}) {
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

// Pixels of a colour: red over blue, blue over red.
std::pair<int, int> warm_and_cold(const Picture& picture) {
  int warm = 0, cold = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const int r = picture.pixels[i], b = picture.pixels[i + 2];
    warm += r > b + 60 ? 1 : 0;
    cold += b > r + 60 ? 1 : 0;
  }
  return {warm, cold};
}

// A bar that hangs by its left end bends: its stress is largest there, its displacement at the
// other end. At first it is unloaded.
TEST(TetsView, DisplacementAndStressAreColoured) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  TetsData data = testing::small_tets();
  data.surface = testing::drawn_boundary(data.mesh);
  EXPECT_TRUE(write_tets(folder + "/held.tets", data));
  std::ofstream(folder + "/one.toml")
      << "step = 0.005\nduration = 1\ngravity = [0, 0, -9.81]\n[[bodies]]\nname = \"held\"\n"
         "kind = \"tets\"\nmodel = \"held.tets\"\nbeta = 0.02\n";
  const std::string view = "--size 200x150 --background white --lights 2 --camera 0,0 --colour ";
  for (const char* colour : {"stress", "moved"}) {
    const testing::Shots rest = testing::shoot(folder, "one.toml", view + colour);
    ASSERT_EQ(rest.result.code, 0) << rest.result.err;
    const auto [warm, cold] = warm_and_cold(testing::picture_of(rest, 0));
    EXPECT_EQ(warm, 0) << colour;
    EXPECT_GT(cold, 3000) << colour;
    const testing::Shots bent = testing::shoot(folder, "one.toml", view + colour + " --from 0.5");
    ASSERT_EQ(bent.result.code, 0) << bent.result.err;
    const auto [red, blue] = warm_and_cold(testing::picture_of(bent, 0));
    EXPECT_GT(red, 300) << colour;
    EXPECT_GT(blue, 300) << colour;
    if (std::string(colour) != "stress") continue;
    EXPECT_EQ(rest.json["largest_stress"], 0.0);
    // Weight rho g L along a beam of height L/2: 3 rho g L^2 / h = 6 rho g L at the wall.
    EXPECT_GT(bent.json["largest_stress"].get<double>(), 1000.0 * 9.81 * 0.2);
    EXPECT_LT(bent.json["largest_stress"].get<double>(), 20.0 * 1000.0 * 9.81 * 0.2);
  }
}

// The front of the bar has the whole image: red on the left, blue on the right. Its last columns
// are not mixed with those of the other edge.
TEST(TetsView, ATextureIsDrawnUpToItsEdges) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  TetsData data = testing::small_tets();
  data.surface = testing::drawn_boundary(data.mesh);
  for (const Vector3d& x : data.surface.vertices)
    data.surface.uvs.emplace_back(static_cast<float>(x.x() / 0.2), static_cast<float>(x.z() / 0.1));
  EXPECT_TRUE(write_tets(folder + "/held.tets", data));
  std::ofstream(folder + "/one.toml")
      << "step = 0.01\nduration = 1\ngravity = [0, 0, 0]\n[[bodies]]\nname = \"held\"\n"
         "kind = \"tets\"\nmodel = \"held.tets\"\n[[bodies]]\nname = \"other\"\n"
         "kind = \"tets\"\nmodel = \"held.tets\"\nposition = [9, 0, 0]\n";
  Picture image{8, 4, {}};
  for (int k = 0; k < 32; ++k)
    for (const int channel : {255 * (k % 8 < 4), 0, 255 * (k % 8 >= 4)})
      image.pixels.push_back(static_cast<std::uint8_t>(channel));
  ASSERT_TRUE(write_png(folder + "/skin.png", image));
  std::string text = testing::slurp(folder + "/one.toml");
  std::ofstream(folder + "/world.toml")
      << text.substr(0, text.find("[[bodies]]\nname = \"other\""))
      << "[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"sphere\"\nradius = 0.02\n"
         "position = [0.1, 0.5, 0.05]\n";
  std::ofstream(folder + "/one.toml") << text.substr(0, text.find("[[bodies]]\nname = \"other\""));
  for (const char* scene : {"one.toml", "world.toml"}) {
    const testing::Shots shots = testing::shoot(
        folder, scene,
        "--size 400x300 --background white --lights 2 --camera 0,0 --texture skin.png "
        "--no-colliders");
    ASSERT_EQ(shots.result.code, 0) << scene << shots.result.err;
    const Picture picture = testing::picture_of(shots, 0);
    int red = 0, blue = 0, mixed = 0;
    for (int y = 0; y < picture.height; ++y) {
      int left = -1, right = -1;
      const auto at = [&](int x) { return picture.pixels.data() + 3 * (y * picture.width + x); };
      for (int x = 0; x < picture.width; ++x) {
        const bool white = at(x)[0] > 200 && at(x)[2] > 200;
        if (white) continue;
        if (left < 0) left = x;
        right = x;
        red += at(x)[0] > at(x)[2] + 60 ? 1 : 0;
        blue += at(x)[2] > at(x)[0] + 60 ? 1 : 0;
      }
      if (right - left < 50) continue;
      // Behind the pixel that the outline covers in part.
      for (int k = 1; k < 12; ++k) mixed += at(left + k)[2] > 40 || at(right - k)[0] > 40 ? 1 : 0;
    }
    EXPECT_GT(red, 3000) << scene;
    EXPECT_GT(blue, 3000) << scene;
    EXPECT_EQ(mixed, 0) << scene;
  }
  const auto refused = [&](const std::string& flags, const std::string& word) {
    const auto result =
        testing::run_program(folder, testing::kView + flags + " --offscreen --out b");
    EXPECT_EQ(result.code, 3) << flags << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
  };
  refused("one.toml --texture side=skin.png", "no names");
  two_whole_bars(folder);
  refused("bars.toml --texture skin.png", "no body has texture coordinates");
}

}  // namespace
}  // namespace tremolo
