// runtime/tremolo_scene.h: worlds of bodies of all kinds from C. A world that calls make has the
// same bits as that of a scene file with the same values.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/tremolo_scene.h"
#include "tests/support/programs.h"

extern "C" {
int tremolo_c_scene_by_calls(const char* basis, const char* tets, tremolo_scene** scene);
int tremolo_c_scene_world_round(const tremolo_scene* scene);
int tremolo_c_scene_refusals(const char* tets);
}

namespace tremolo {
namespace {

class SceneCApi : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    TetMesh mesh = box_mesh({2, 2, 2}, {0.1, 0.1, 0.1});
    for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(0.05);
    write_veg(folder_ + "/cube.veg", mesh);
    for (const char* what :
         {"tets cube.veg --young 1e5 --poisson 0.3 --density 1000 --fix none -o cube.tets",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
          "--order 1 -o cube.tremolo"}) {
      const ProgramResult made = run_program(folder_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }
  void TearDown() override {
    for (tremolo_scene* scene : scenes_) tremolo_scene_destroy(scene);
    for (tremolo_scene_world* world : worlds_) tremolo_scene_world_destroy(world);
  }

  static std::string path(const std::string& name) { return folder_ + "/" + name; }

  tremolo_scene* keep(tremolo_scene* scene) { return scenes_.emplace_back(scene); }
  tremolo_scene* by_calls() {
    tremolo_scene* scene = nullptr;
    EXPECT_EQ(
        tremolo_c_scene_by_calls(path("cube.tremolo").c_str(), path("cube.tets").c_str(), &scene),
        0)
        << "line of scene_c_api_test.c; " << tremolo_last_error();
    return keep(scene);
  }
  tremolo_scene_world* world_of(const tremolo_scene* scene, std::uint32_t threads = 1) {
    tremolo_scene_world* world = nullptr;
    EXPECT_EQ(tremolo_scene_world_create(scene, threads, &world), TREMOLO_OK)
        << tremolo_last_error();
    return worlds_.emplace_back(world);
  }
  static std::vector<std::byte> saved(const tremolo_scene_world* world) {
    std::size_t size = 0;
    EXPECT_EQ(tremolo_scene_world_save(world, nullptr, 0, &size), TREMOLO_OK);
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(tremolo_scene_world_save(world, bytes.data(), size, &size), TREMOLO_OK);
    return bytes;
  }
  static void advance(tremolo_scene_world* world, int steps) {
    ASSERT_EQ(tremolo_scene_world_step(world, steps, nullptr), TREMOLO_OK) << tremolo_last_error();
  }

  static inline std::string folder_;
  std::vector<tremolo_scene*> scenes_;
  std::vector<tremolo_scene_world*> worlds_;
};

// The scene of tremolo_c_scene_by_calls().
const std::string kText = R"(
step = 0.002
gravity = [0, 0, -9.81]
[[bodies]]
name = "sheet"
kind = "cloth"
integrator = "midpoint"
columns = 7
rows = 7
width = 0.18
height = 0.18
corner = [-0.09, -0.09, 0.24]
structural = [200, 0.01]
shear = [60, 0.01]
bend = [2, 0.001]
velocity = [0, 0, -0.1]
pins = [0, 6]
[[bodies]]
name = "soft"
kind = "free"
model = "cube.tremolo"
shape = "box"
half-extents = [0.05, 0.05, 0.05]
position = [0.06, 0, 0.0503]
beta = 0.001
[[bodies]]
name = "cube"
kind = "tets"
model = "cube.tets"
position = [0.01, 0, 0.157]
spin = [0, 1, 0]
integrator = "midpoint"
degree = "quadratic"
[[bodies]]
name = "hard"
kind = "rigid"
shape = "box"
half-extents = [0.05, 0.05, 0.05]
mass = 1
position = [-0.06, 0, 0.0503]
friction = 0.5
[[colliders]]
name = "collider 1"
shape = "plane"
friction = 0.4
)";

TEST_F(SceneCApi, AWorldByCallsHasTheBitsOfItsFile) {
  std::ofstream(path("scene.toml")) << kText;
  tremolo_scene *file = nullptr, *text = nullptr;
  ASSERT_EQ(tremolo_scene_read(path("scene.toml").c_str(), &file), TREMOLO_OK)
      << tremolo_last_error();
  keep(file);
  ASSERT_EQ(tremolo_scene_parse(kText.c_str(), path("elsewhere.toml").c_str(), &text), TREMOLO_OK)
      << tremolo_last_error();
  keep(text);
  tremolo_scene_world* calls = world_of(by_calls());
  tremolo_scene_world* of_file = world_of(file, 2);
  tremolo_scene_world* of_text = world_of(text);
  for (int k = 0; k < 3; ++k) {
    for (tremolo_scene_world* world : worlds_) advance(world, 40);
    EXPECT_TRUE(saved(calls) == saved(of_file)) << k;
    EXPECT_TRUE(saved(calls) == saved(of_text)) << k;
  }
  std::int64_t contacts = 0;
  for (std::uint32_t body = 0; body < 4; ++body) {
    ASSERT_EQ(tremolo_scene_world_contact(calls, body, &contacts, nullptr, nullptr, nullptr),
              TREMOLO_OK);
    EXPECT_GT(contacts, 0) << tremolo_scene_world_name(calls, body);
  }
}

// What the program saves a library continues, and the other way round.
TEST_F(SceneCApi, StatesAreThoseOfThePrograms) {
  std::ofstream(path("scene.toml")) << kText;
  const ProgramResult run = run_program(
      folder_, TREMOLO_BIN_DIR "/tremolo run scene.toml --duration 0.1 --save end.saved");
  if (run.code == 127) GTEST_SKIP() << "the program is not built";
  ASSERT_EQ(run.code, 0) << run.err;
  tremolo_scene_world* world = world_of(by_calls());
  advance(world, 50);
  const std::string bytes = testing::slurp(path("end.saved"));
  const std::vector<std::byte> own = saved(world);
  EXPECT_TRUE(std::string(reinterpret_cast<const char*>(own.data()), own.size()) == bytes);
  tremolo_scene_world* other = world_of(by_calls());
  ASSERT_EQ(tremolo_scene_world_restore(other, bytes.data(), bytes.size()), TREMOLO_OK)
      << tremolo_last_error();
  advance(world, 30);
  advance(other, 30);
  EXPECT_TRUE(saved(world) == saved(other));
}

TEST_F(SceneCApi, RoundFromC) {
  EXPECT_EQ(tremolo_c_scene_world_round(by_calls()), 0)
      << "line of scene_c_api_test.c; " << tremolo_last_error();
}

TEST_F(SceneCApi, RefusesFromC) {
  EXPECT_EQ(tremolo_c_scene_refusals(path("cube.tets").c_str()), 0)
      << "line of scene_c_api_test.c; " << tremolo_last_error();
}

}  // namespace
}  // namespace tremolo
