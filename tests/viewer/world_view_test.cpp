// Worlds with cloths and bodies of tetrahedra in the viewer: their surfaces, their pictures, the
// thread of the window.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "formats/polygons/polygon_mesh.h"
#include "formats/tets/tets_file.h"
#include "runtime/apps/view/live/runner.h"
#include "tests/support/meshes/small_tets.h"
#include "tests/viewer/masks.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::expect_alike;
using testing::expected_mask;
using testing::fresh_folder;
using testing::kFlat;
using testing::picture_of;
using testing::run_program;
using testing::seen_mask;
using testing::shoot;
using testing::Shots;

GivenFlags no_flags() {
  return {RunOptions{}, [](const char*) { return false; }};
}

// A sheet and a ball fall on a table; a bar of tetrahedra bends next to them. Returns the scene.
std::string write_mixed(const std::string& folder) {
  TetsData data = testing::small_tets();
  data.surface = testing::drawn_boundary(data.mesh);
  data.nodes = {};
  data.distances.clear();
  EXPECT_TRUE(write_tets(folder + "/bar.tets", data));
  std::ofstream(folder + "/mixed.toml")
      << "step = 0.005\nduration = 0.3\ngravity = [0, 0, -9.81]\n"
         "[[bodies]]\nname = \"bar\"\nkind = \"tets\"\nmodel = \"bar.tets\"\n"
         "position = [0.3, 0, 0.2]\nbeta = 0.01\n"
         "[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\ncolumns = 13\nrows = 13\n"
         "width = 0.5\nheight = 0.5\ncorner = [-0.3, -0.25, 0.12]\nthickness = 0.01\n"
         "[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"sphere\"\nradius = 0.05\n"
         "mass = 0.1\nposition = [0, 0, 0.2]\n"
         "[[colliders]]\nname = \"table\"\nshape = \"box\"\nhalf-extents = [0.1, 0.1, 0.05]\n"
         "position = [-0.05, 0, 0.05]\n";
  return folder + "/mixed.toml";
}

Result<LiveWorld> live_of(const std::string& scene, ModelCache& models) {
  const Result<ViewedScene> viewed = read_viewed_scene(scene, no_flags());
  if (!viewed) return viewed.error();
  return LiveWorld::create(*viewed, models);
}

// The surfaces that `tremolo run` writes at the end of the scene.
std::vector<SurfaceMesh> surfaces_at_end(const std::string& folder, const std::string& scene,
                                         const std::vector<std::string>& bodies) {
  const auto run =
      run_program(folder, TREMOLO_BIN_DIR "/tremolo run " + scene + " --out ran --surfaces 2");
  EXPECT_EQ(run.code, 0) << run.err;
  std::vector<SurfaceMesh> surfaces;
  for (const std::string& body : bodies) {
    fs::path last;
    for (const auto& entry : fs::directory_iterator(folder + "/ran/" + body))
      if (entry.path().extension() == ".ply" && entry.path() > last) last = entry.path();
    EXPECT_NE(last.string().find("t0.3"), std::string::npos) << last;
    Result<SurfaceMesh> read = read_surface_triangles(last.string());
    EXPECT_TRUE(read) << (read ? "" : read.error().message);
    if (read) surfaces.push_back(std::move(*read));
  }
  return surfaces;
}

TEST(WorldView, GuestsAreWhereARunHasThem) {
  const std::string folder = fresh_folder(), scene = write_mixed(folder);
  const std::vector<SurfaceMesh> ran = surfaces_at_end(folder, scene, {"bar", "sheet"});
  ASSERT_EQ(ran.size(), 2U);
  ModelCache models;
  Result<LiveWorld> live = live_of(scene, models);
  ASSERT_TRUE(live) << live.error().message;
  ASSERT_EQ(live->guests().size(), 2U);
  EXPECT_TRUE(live->guests().is_held(0));
  EXPECT_FALSE(live->guests().is_held(1));
  const WorldMoment start = live->now();
  while (live->now().time < 0.3 - 1e-9) ASSERT_TRUE(live->step());
  EXPECT_EQ(live->trouble(), "");
  EXPECT_GT(live->guests().contacts(), 0) << "the sheet is on the table";
  for (std::size_t i = 0; i < 2; ++i) {
    const std::vector<float>& shown = live->now().bodies[1 + i].positions;
    ASSERT_EQ(shown.size(), 3 * ran[i].vertices.size());
    ASSERT_EQ(live->guests().triangles(i).size(), ran[i].triangles.size());
    float moved = 0.0F;
    for (std::size_t v = 0; v < ran[i].vertices.size(); ++v)
      for (std::size_t k = 0; k < 3; ++k) {
        // Files have floats, too.
        EXPECT_NEAR(shown[3 * v + k], ran[i].vertices[v][static_cast<Eigen::Index>(k)], 1e-6);
        moved =
            std::max(moved, std::abs(shown[3 * v + k] - start.bodies[1 + i].positions[3 * v + k]));
      }
    EXPECT_GT(moved, 0.01F) << "it does move";
  }
}

TEST(WorldView, ThePictureShowsTheSurfacesOfTheRun) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder(), scene = write_mixed(folder);
  const std::vector<SurfaceMesh> ran = surfaces_at_end(folder, scene, {"bar", "sheet", "ball"});
  ASSERT_EQ(ran.size(), 3U);
  for (const char* camera : {"10,25", "200,-20,0.8"}) {
    const Shots shots =
        shoot(folder, scene, kFlat + "--size 400x300 --from 0.3 --no-colliders --camera " + camera);
    ASSERT_EQ(shots.result.code, 0) << shots.result.err;
    expect_alike(seen_mask(picture_of(shots, 0)), expected_mask(ran, shots.json));
  }
}

// The scenes of the repository, as they are, where their models are.
TEST(WorldView, TheSampleScenesAreDrawn) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  for (const std::string name :
       {"trampoline-ducks", "tablecloth", "blanket", "mixed-stack", "gripper", "dominoes"}) {
    const Shots shots = shoot(fresh_folder(), TREMOLO_SOURCE_DIR "/assets/scenes/" + name + ".toml",
                              "--size 160x120 --frames 2 --rate 50 --lights 2");
    if (shots.result.code == 1 && shots.result.err.find("there is no such") != std::string::npos)
      GTEST_SKIP() << shots.result.err;
    ASSERT_EQ(shots.result.code, 0) << name << shots.result.err;
    EXPECT_NE(picture_of(shots, 0).pixels, picture_of(shots, 1).pixels) << name;
  }
}

// Mean of the pixels that are not white, 0 to 255.
double mean_light(const Picture& picture) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3)
    if (picture.pixels[i + 2] < 250) {
      sum += picture.pixels[i];
      ++count;
    }
  EXPECT_GT(count, 1000);
  return sum / count;
}

// A sheet in the air, whose triangles all face up: from below it is as light as the lamps there
// make it, not black as a surface would be that faces away from all of them.
TEST(WorldView, BothSidesOfASheetAreLit) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/sheet.toml")
      << "step = 0.01\n[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\ncolumns = 5\nrows = 5\n"
         "corner = [0, 0, 1]\n[[bodies]]\nname = \"far\"\nkind = \"rigid\"\nshape = \"sphere\"\n"
         "radius = 0.01\nmass = 1\nposition = [0.5, 0.5, 0.5]\n";
  const std::string flags = "--size 200x150 --background white --paint '#b06030' --camera 0,";
  std::vector<double> light;
  for (const char* elevation : {"60", "-60"}) {
    const Shots shots = shoot(folder, folder + "/sheet.toml", flags + elevation);
    ASSERT_EQ(shots.result.code, 0) << shots.result.err;
    light.push_back(mean_light(picture_of(shots, 0)));
  }
  EXPECT_GT(light[0], 150.0);
  EXPECT_GT(light[1], 60.0);
  EXPECT_LT(light[1], light[0]);
}

// Pixels of a colour: red over blue, blue over red.
std::pair<int, int> red_and_blue(const Picture& picture) {
  int red = 0, blue = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const int r = picture.pixels[i], b = picture.pixels[i + 2];
    red += r > b + 60 ? 1 : 0;
    blue += b > r + 60 ? 1 : 0;
  }
  return {red, blue};
}

TEST(WorldView, ColoursAreThoseOfTheBodiesThatHaveThem) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder(), scene = write_mixed(folder);
  const std::string view = "--size 200x150 --background white --lights 2 --no-colliders ";
  const auto picture = [&](const std::string& flags) {
    const Shots shots = shoot(folder, scene, view + flags);
    EXPECT_EQ(shots.result.code, 0) << flags << shots.result.err;
    return red_and_blue(picture_of(shots, 0));
  };
  // At the start nothing is deformed.
  EXPECT_EQ(picture("--colour moved --moved-full 0.01").first, 0);
  const auto [bent, rest] = picture("--colour moved --from 0.3");
  EXPECT_GT(bent, 100) << "the corners of the sheet";
  EXPECT_GT(rest, 100);
  // Red is a body's own colour, of one by its name.
  const auto [own, others] = picture("--paint '#0000ff' --paint sheet=#ff0000");
  EXPECT_GT(own, 1000);
  EXPECT_GT(others, 500);
  // The bar begins with linear edges, and the rest keeps its colour.
  const auto [quadratic, linear] = picture("--paint '#808080' --colour degree");
  EXPECT_EQ(quadratic, 0);
  EXPECT_GT(linear, 100);
}

TEST(WorldView, WhatNoBodyHasIsRefused) {
  const std::string folder = fresh_folder(), scene = write_mixed(folder);
  const auto expect_refused = [&](const std::string& flags, int code, const std::string& word) {
    const auto result = run_program(folder, testing::kView + flags);
    EXPECT_EQ(result.code, code) << flags << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << flags << result.err;
  };
  expect_refused("mixed.toml --orbit 1:5% --offscreen --out a", 2, "--orbit");
  expect_refused("mixed.toml --integrator ep2 --offscreen --out a", 2, "--integrator");
  expect_refused("mixed.toml --paint nobody=#ffffff --offscreen --out a", 3, "no body");
  std::ofstream(folder + "/plain.toml") << "[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\n"
                                           "shape = \"sphere\"\nradius = 0.05\nmass = 0.1\n";
  expect_refused("plain.toml --colour stress --offscreen --out a", 3, "material");
  expect_refused("plain.toml --colour degree --offscreen --out a", 2, "tets");
}

CameraRay down_at(double x, double y) {
  return {Vector3d(x, y, 2.0), -Vector3d::UnitZ()};
}

TEST(WorldView, AHandPullsAGuestAndGivesItsWork) {
  ModelCache models;
  Result<LiveWorld> live = live_of(write_mixed(fresh_folder()), models);
  ASSERT_TRUE(live) << live.error().message;
  const auto nothing = live->take(down_at(3.0, 3.0), 1.0);
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->has_value());
  const auto wall = live->take(down_at(0.301, 0.05), 1.0);
  ASSERT_FALSE(wall) << "the bar is fixed there";
  EXPECT_NE(wall.error().message.find("bar: "), std::string::npos) << wall.error().message;
  // The ball hides the middle of the sheet.
  ASSERT_TRUE(live->take(down_at(0.0, 0.0), 1.0));
  EXPECT_EQ(live->hand().name(live->world()), "ball");
  EXPECT_NEAR(live->hand().begun().z(), 0.25, 0.01);
  // The free end of the bar, once it hangs at rest, follows the hand by four fifths of its way.
  live->hand().let_go(live->world());
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(live->step());
  const auto taken = live->take(down_at(0.499, 0.05), 1.0);
  ASSERT_TRUE(taken && *taken) << taken.error().message;
  EXPECT_LE((live->hand().begun() - **taken).norm(), 0.06) << "a vertex of the triangle";
  const Vector3d begun = live->hand().begun(), way(0.0, 0.0, 0.01);
  for (int k = 1; k <= 200; ++k) {
    live->hand().move(std::min(1.0, 0.01 * k) * way);
    ASSERT_TRUE(live->step());
  }
  EXPECT_EQ(live->trouble(), "");
  const double followed = (live->hand().held(live->world()) - begun).z();
  EXPECT_NEAR(followed, 0.8 * way.z(), 0.1 * way.z());
  EXPECT_NEAR(live->now().hands.back().held.z(), begun.z() + followed, 1e-12);
  EXPECT_GT(live->guests().hand_work(), 0.0);
  live->hand().let_go(live->world());
  EXPECT_FALSE(live->hand().holds());
}

// A corner of the sheet is pulled up: its hand carries it to the side of the table.
TEST(WorldView, AHandPullsASheet) {
  ModelCache models;
  Result<LiveWorld> live = live_of(write_mixed(fresh_folder()), models);
  ASSERT_TRUE(live) << live.error().message;
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(live->step());
  const auto taken = live->take(down_at(-0.15, 0.0), 1.0);
  ASSERT_TRUE(taken && *taken) << (taken ? "nothing" : taken.error().message);
  const Vector3d begun = live->hand().begun();
  EXPECT_LE((begun - **taken).norm(), 0.04) << "a particle of the triangle";
  for (int k = 1; k <= 80; ++k) {
    live->hand().move(0.002 * k * Vector3d::UnitZ());
    ASSERT_TRUE(live->step());
  }
  EXPECT_EQ(live->trouble(), "");
  EXPECT_GT((live->hand().held(live->world()) - begun).z(), 0.04);
  EXPECT_GT(live->guests().hand_work(), 0.0);
  ASSERT_TRUE(live->begin_again(models));
  EXPECT_FALSE(live->hand().holds());
  EXPECT_EQ(live->guests().hand_work(), 0.0);
}

// Pulls what is below the ray, records it, and runs the recorded scene.
void expect_recorded(const CameraRay& ray, const std::string& name) {
  const std::string folder = fresh_folder(), scene = write_mixed(folder);
  ModelCache models;
  Result<LiveWorld> live = live_of(scene, models);
  ASSERT_TRUE(live) << live.error().message;
  HandRecord record;
  const auto taken = live->take(ray, 1.0);
  ASSERT_TRUE(taken && *taken) << name;
  EXPECT_EQ(live->hand().name(live->world()), name);
  for (int k = 1; k <= 40; ++k) {
    live->hand().move(Vector3d(0.001 * k, 0.0, -0.002 * k));
    record.before_step(*live);
    ASSERT_TRUE(live->step());
  }
  record.end(live->world().time());
  live->hand().let_go(live->world());
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(live->step());
  fs::create_directory(folder + "/deep");
  const std::string path = folder + "/deep/hand.toml";
  const Status written = write_recorded_scene(path, *live, record.hands());
  ASSERT_TRUE(written) << written.error().message;
  Result<LiveWorld> again = live_of(path, models);
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->viewed().scene.hands.size(), 1U);
  while (again->now().time < live->now().time) ASSERT_TRUE(again->step());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(again->now().bodies[i].positions, live->now().bodies[i].positions) << name << i;
    EXPECT_EQ(again->now().bodies[i].pose.position, live->now().bodies[i].pose.position) << i;
  }
  const double work =
      std::abs(again->world().body(0).contact_sums().hand) + std::abs(again->guests().hand_work());
  EXPECT_GT(work, 1e-6) << name;
}

// The guests are before the ball in the scene, and keep their methods.
TEST(WorldView, ARecordOfABodyAmongGuestsRepeatsTheMotion) {
  expect_recorded(down_at(0.0, 0.0), "ball");
}
TEST(WorldView, ARecordOfAGuestRepeatsTheMotion) {
  expect_recorded(down_at(-0.25, 0.2), "sheet");
  expect_recorded(down_at(0.45, 0.05), "bar");
}

TEST(WorldView, ADragInTheWindowPullsASheet) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/sheet.toml")
      << "step = 0.01\n[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\ncolumns = 9\nrows = 9\n"
         "corner = [-0.5, -0.5, 0]\n";
  const auto [shots, no_window] =
      testing::drag_in_window(folder, "560 290", "sheet.toml --camera 0,60");
  if (!no_window.empty()) GTEST_SKIP() << no_window;
  const auto& [result, json] = shots;
  ASSERT_EQ(result.code, 0) << result.err;
  ASSERT_FALSE(json.is_discarded()) << result.out << result.err;
  EXPECT_GT(json["hand_work"].get<double>(), 0.0) << result.out;
  EXPECT_GT(json["mouse_moves"].get<int>(), 0) << result.out;
  EXPECT_GT(json["steps"].get<int>(), 50) << result.out;
  EXPECT_EQ(json["trouble"], "") << result.out;
}

// The window's thread: paused, single steps, from the start again.
TEST(WorldView, TheRunnerStepsGuestsAndBeginsAgain) {
  const std::string scene = write_mixed(fresh_folder());
  ModelCache models;
  Result<LiveWorld> live = live_of(scene, models);
  ASSERT_TRUE(live) << live.error().message;
  const WorldMoment start = live->now();
  Runner runner(std::move(*live), 1.0, true, false);
  const auto wait_for = [&runner](std::int64_t steps) {
    while (runner.report().steps < steps) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  runner.step_once();
  wait_for(1);
  runner.step_once();
  wait_for(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_EQ(runner.report().steps, 2);
  runner.set_paused(false);
  wait_for(10);
  runner.set_paused(true);
  runner.settle();
  WorldMoment moment;
  runner.look(moment);
  ASSERT_EQ(moment.bodies.size(), 3U);
  EXPECT_NE(moment.bodies[2].positions, start.bodies[2].positions);
  EXPECT_GT(runner.report().energies.back().potential, 0.0);
  runner.post([&models](LiveWorld& world) {
    EXPECT_FALSE(world.world().set_step(0.001)) << "guests have the step of the scene";
    ASSERT_TRUE(world.begin_again(models));
  });
  runner.settle();
  runner.look(moment);
  EXPECT_EQ(moment.time, 0.0);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(moment.bodies[i].positions, start.bodies[i].positions) << i;
}

}  // namespace
}  // namespace tremolo
