// Cloth in the viewer: rays, hands, pictures, the window.
#include <fstream>

#include "runtime/apps/view/cloth/cloth_scenes.h"
#include "runtime/apps/view/picture/png_file.h"
#include "tests/viewer/masks.h"
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

TEST(ClothView, MethodsAndStepsAreSwitchedAndRefusedBeyondTheirLimit) {
  Result<ClothScenes> scenes = two_squares();
  ASSERT_TRUE(scenes) << scenes.error().message;
  ASSERT_EQ(scenes->methods().size(), 12U);
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(scenes->step());
  ASSERT_TRUE(scenes->choose(1, "energy"));
  EXPECT_EQ(scenes->chosen(), (std::vector<std::string>{"implicit-euler", "energy"}));
  const Eigen::VectorXd x = scenes->shown()[0].world.positions(0);
  const Status refused = scenes->choose(0, "rk4");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("the limit is"), std::string::npos)
      << refused.error().message;
  EXPECT_FALSE(scenes->choose(0, "magic"));
  EXPECT_FALSE(scenes->set_step_size(0.0));
  EXPECT_EQ(scenes->chosen()[0], "implicit-euler");
  EXPECT_EQ(scenes->shown()[0].world.positions(0), x);
  ASSERT_TRUE(scenes->set_step_size(1e-4));
  EXPECT_NEAR(scenes->time(), 0.1, 5e-5);
  EXPECT_EQ(scenes->shown()[1].world.scene().options.step, 1e-4);
  ASSERT_TRUE(scenes->choose(0, "rk4"));
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(scenes->step());
  EXPECT_NEAR(scenes->time(), 0.101, 5e-5);
  // The step that the first one cannot take is given to neither.
  EXPECT_FALSE(scenes->set_step_size(1.0 / 60.0));
  EXPECT_EQ(scenes->shown()[1].world.scene().options.step, 1e-4);
  ASSERT_TRUE(scenes->begin_again());
  EXPECT_EQ(scenes->chosen()[0], "rk4");
  EXPECT_EQ(scenes->step_size(), 1e-4);
}

// Two pulls, of which the second is not released.
TEST(ClothView, ARecordedHandDoesItAgainToTheBit) {
  for (const char* method : {"implicit-euler", "bdf2", "energy"}) {
    Result<ClothFile> file = parse_cloths(kSquare, "square.toml");
    ASSERT_TRUE(file) << file.error().message;
    file->scene.integrator = method;
    Result<ClothScenes> scenes = ClothScenes::create({*file});
    ASSERT_TRUE(scenes) << scenes.error().message;
    ASSERT_TRUE(scenes->record_hand());
    EXPECT_FALSE(scenes->choose(0, "energy"));
    EXPECT_FALSE(scenes->set_step_size(0.001));
    for (int k = 0; k < 40; ++k) {
      if (k == 3 || k == 25) {
        ASSERT_TRUE(scenes->take({Vector3d(0.22, -0.28, 3.0), -Vector3d::UnitZ()})) << k;
      }
      if (k == 17) scenes->let_go();
      // It rests for some steps in between.
      if (scenes->hand())
        scenes->move_to(*scenes->hand() + Vector3d(0.0013, 0.0007, k < 8 || k > 12 ? 0.003 : 0.0));
      ASSERT_TRUE(scenes->step());
    }
    const std::string path = fresh_folder() + "/hand.toml";
    ASSERT_TRUE(scenes->write_hand(path));
    const Result<ClothFile> again = parse_cloths(testing::slurp(path), path);
    ASSERT_TRUE(again) << again.error().message;
    ASSERT_EQ(again->scene.hands.size(), 2U);
    EXPECT_EQ(again->scene.integrator, method);
    Result<ClothWorld> world = ClothWorld::create(again->scene);
    ASSERT_TRUE(world) << world.error().message;
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(world->step());
    EXPECT_EQ(world->positions(0), scenes->shown()[0].world.positions(0)) << method;
    EXPECT_EQ(world->energy().pins, scenes->shown()[0].world.energy().pins) << method;
  }
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
    if (picture->pixels[3 * i + 2] > 128) continue;
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

// Particles are outside of a box, triangles between them cut off its edge: a sheet lies over the
// whole of a box that is seen from a corner, so that nothing of the box is seen.
TEST(ClothView, EdgesOfABoxAreNotSeenThroughTheSheetThatLiesOnThem) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  // Rows of particles over the top of the box, 0.05 m from its edge at first, and down its front.
  std::ofstream mesh(folder + "/sheet.obj");
  std::string pins;
  constexpr int kColumns = 11;
  std::vector<Eigen::Vector2d> rows;  // y, z
  for (int k = 6; k >= 0; --k) rows.emplace_back(-0.25 + 0.1 * k, 0.206);
  for (int k = 0; k < 5; ++k) rows.emplace_back(-0.306, 0.15 - 0.1 * k);
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (int column = 0; column < kColumns; ++column) {
      mesh << "v " << -0.5 + 0.1 * column << " " << rows[row].x() << " " << rows[row].y() << "\n";
      pins += (pins.empty() ? "" : ", ") + std::to_string(row * kColumns + column);
    }
  for (std::size_t row = 0; row + 1 < rows.size(); ++row)
    for (int column = 0; column + 1 < kColumns; ++column) {
      const std::size_t a = row * kColumns + column + 1, b = a + kColumns;
      mesh << "f " << a << " " << b << " " << b + 1 << "\nf " << a << " " << b + 1 << " " << a + 1
           << "\n";
    }
  mesh.close();
  std::ofstream(folder + "/box.toml")
      << "duration = 1\nstep = 0.01\n[[cloths]]\nname = \"sheet\"\nfile = \"sheet.obj\"\npins = ["
      << pins
      << "]\n[[colliders]]\nname = \"box\"\nshape = \"box\"\nhalf-extents = [0.3, 0.3, 0.2]\n";
  const testing::Shots shots =
      testing::shoot(folder, "box.toml",
                     "--size 300x300 --camera 0,45 --background '#000000' --paint '#400000' "
                     "--lights 8");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  const Result<Picture> picture = read_png(shots.json["frames"][0]["file"]);
  ASSERT_TRUE(picture);
  int sheet = 0, box = 0;
  for (std::size_t i = 0; i < picture->pixels.size(); i += 3) {
    sheet += picture->pixels[i] > 25 ? 1 : 0;
    box += picture->pixels[i + 2] > 60 ? 1 : 0;
  }
  EXPECT_GT(sheet, 10000);
  EXPECT_EQ(box, 0);
}

// A wall behind the square is glass: no shadow of the square floats on it.
TEST(ClothView, ShadowsAreNotSeenOnWallsThatAreGlass) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  const std::string flags = "--size 200x200 --camera 0,20,0.5 --background '#000000' --lights 4";
  const auto picture = [&](const std::string& name, const std::string& scene) {
    std::ofstream(folder + "/" + name + ".toml") << scene;
    const testing::Shots shots = testing::shoot(folder, name + ".toml", flags);
    EXPECT_EQ(shots.result.code, 0) << shots.result.err;
    Result<Picture> shown = read_png(shots.json["frames"][0]["file"]);
    EXPECT_TRUE(shown);
    return shown ? std::move(*shown) : Picture{};
  };
  const std::string wall =
      "[[colliders]]\nname = \"wall\"\nshape = \"plane\"\nposition = [0, 0.6, 1]\n"
      "quaternion = [0.70710678118654752, 0.70710678118654752, 0, 0]\n";
  const Picture alone = picture("alone", kSquare), walled = picture("walled", kSquare + wall);
  ASSERT_EQ(alone.pixels.size(), walled.pixels.size());
  int least = 255, largest = 0, count = 0;
  for (std::size_t i = 0; i < alone.pixels.size(); i += 3) {
    const int green = walled.pixels[i + 1];
    if (alone.pixels[i + 1] > 0 || green == 0) continue;  // the square, or beyond the wall's disc
    least = std::min(least, green);
    largest = std::max(largest, green);
    ++count;
  }
  EXPECT_GT(count, 10000);
  // Shine of the lamp changes over the wall, a shadow takes a third of its light.
  EXPECT_GT(least, 0.85 * largest);
}

// An upright grid has the whole image, u along `along`: red on the left, blue on the right. So has
// a file with a seam in the middle, whose two sides have different texture coordinates.
TEST(ClothView, ATextureIsDrawnOnGridsAndFilesAloneAndAmongOthers) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  Picture image{8, 2, {}};
  for (int k = 0; k < 16; ++k)
    for (const int channel : {255 * (k % 8 < 4), 0, 255 * (k % 8 >= 4)})
      image.pixels.push_back(static_cast<std::uint8_t>(channel));
  ASSERT_TRUE(write_png(folder + "/skin.png", image));
  std::ofstream(folder + "/seam.obj")
      << "v -0.5 0 0\nv 0 0 0\nv 0.5 0 0\nv -0.5 0 1\nv 0 0 1\nv 0.5 0 1\n"
         "vt 0 0\nvt 0.4 0\nvt 0.4 1\nvt 0 1\nvt 0.6 0\nvt 1 0\nvt 1 1\nvt 0.6 1\n"
         "f 1/1 2/2 5/3\nf 1/1 5/3 4/4\nf 2/5 3/6 6/7\nf 2/5 6/7 5/8\n";
  const std::string head = "duration = 1\nstep = 0.01\ngravity = [0, 0, 0]\n";
  const std::string grid =
      "columns = 11\nrows = 11\ncorner = [-0.5, 0, 0]\nalong = [1, 0, 0]\nacross = [0, 0, 1]\n";
  const std::string file = "file = \"seam.obj\"\n";
  const std::string ball =
      "[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"sphere\"\nradius = 0.02\n"
      "position = [0, 0.5, 0.5]\n";
  int number = 0;
  for (const std::string& cut : {grid, file})
    for (const bool alone : {true, false}) {
      const std::string scene = "scene" + std::to_string(number++) + ".toml";
      std::ofstream(folder + "/" + scene)
          << head << (alone ? "" : ball)
          << (alone ? "[[cloths]]\n" : "[[bodies]]\nkind = \"cloth\"\n") << "name = \"sheet\"\n"
          << cut;
      const testing::Shots shots =
          testing::shoot(folder, scene,
                         "--size 300x300 --background white --lights 2 --camera 0,0 "
                         "--texture skin.png");
      ASSERT_EQ(shots.result.code, 0) << scene << shots.result.err;
      const Picture picture = testing::picture_of(shots, 0);
      int red = 0, blue = 0, wrong = 0;
      for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
          const std::uint8_t* at = picture.pixels.data() + 3 * (y * picture.width + x);
          const bool is_red = at[0] > at[2] + 60, is_blue = at[2] > at[0] + 60;
          red += is_red ? 1 : 0;
          blue += is_blue ? 1 : 0;
          wrong += (x < 145 && is_blue) || (x > 155 && is_red) ? 1 : 0;
        }
      EXPECT_GT(red, 5000) << scene;
      EXPECT_GT(blue, 5000) << scene;
      EXPECT_EQ(wrong, 0) << scene;
    }
  std::ofstream(folder + "/square.toml") << kSquare;
  const ProgramResult named = run_program(
      folder, testing::kView + "square.toml --texture side=skin.png --offscreen --out a");
  EXPECT_EQ(named.code, 3);
  EXPECT_NE(named.err.find("no names"), std::string::npos) << named.err;
}

TEST(ClothView, FlagsThatAreOfBodiesAreRefused) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  for (const char* flags :
       {"--colour stress --offscreen --out a", "--record-hand a.toml --offscreen --out a",
        "--record-hand a.toml --beside square.toml", "--colour degree --offscreen --out a",
        "--offscreen", "--video a.mp4", "--beside square.toml --step 0 --offscreen --out a"}) {
    const ProgramResult result = run_program(folder, testing::kView + "square.toml " + flags);
    EXPECT_TRUE(result.code == 2 || result.code == 3) << flags << result.err;
  }
}

TEST(ClothView, DisplacementIsColoured) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  const auto red_and_blue = [&](const std::string& flags) {
    const testing::Shots shots = testing::shoot(
        folder, "square.toml",
        "--size 200x150 --background white --lights 2 --camera 0,60 --colour moved " + flags);
    EXPECT_EQ(shots.result.code, 0) << shots.result.err;
    const auto picture = read_png(shots.json["frames"][0]["file"]);
    EXPECT_TRUE(picture);
    std::pair<int, int> count{0, 0};
    for (std::size_t i = 0; picture && i < picture->pixels.size(); i += 3) {
      count.first += picture->pixels[i] > picture->pixels[i + 2] + 60 ? 1 : 0;
      count.second += picture->pixels[i + 2] > picture->pixels[i] + 60 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(red_and_blue("").first, 0);
  const auto [moved, still] = red_and_blue("--from 0.3");
  EXPECT_GT(moved, 100);
  EXPECT_GT(still, 100);
}

TEST(ClothView, ADragInTheWindowPullsAParticleAndTheRecordDoesItAgain) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  const auto [shots, no_window] = testing::drag_in_window(
      folder, "390 290", "square.toml --camera 0,80 --record-hand hand.toml");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  EXPECT_EQ(json["pulls"], 1) << result.out;
  EXPECT_GT(json["longest_pull"].get<double>(), 0.02) << result.out;
  EXPECT_GT(json["pictures"].get<int>(), 3);
  const std::string path = folder + "/hand.toml";
  const Result<ClothFile> again = parse_cloths(testing::slurp(path), path);
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->scene.hands.size(), 1U);
  Result<ClothWorld> world = ClothWorld::create(again->scene);
  ASSERT_TRUE(world) << world.error().message;
  while (world->steps() < json["steps"].get<int>()) ASSERT_TRUE(world->step());
  EXPECT_EQ(world->energy().pins, json["hand_work"].get<double>());
}

TEST(ClothView, AKeyThatIsHeldDownSwitchesOnceAndStepsOften) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/square.toml") << kSquare;
  const auto [shots, no_window] =
      testing::hold_keys(folder, "m bracketleft period", "square.toml --paused");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  Result<ClothScenes> scenes = two_squares();
  ASSERT_TRUE(scenes) << scenes.error().message;
  const auto names = scenes->methods();
  const auto usual = std::find(names.begin(), names.end(), scenes->chosen()[0]);
  EXPECT_EQ(json["methods"][0], *(usual + 1)) << result.out;
  EXPECT_EQ(json["step"], 0.5 * scenes->step_size()) << result.out;
  // So keys do repeat here.
  EXPECT_GT(json["steps"].get<int>(), 5) << result.out;
}

}  // namespace
}  // namespace tremolo
