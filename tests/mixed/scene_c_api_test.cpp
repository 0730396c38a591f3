// runtime/tremolo_scene.h: worlds of bodies of all kinds from C. A world that calls make has the
// same bits as that of a scene file with the same values.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <utility>
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
    for (tremolo_world* world : worlds_) tremolo_world_destroy(world);
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
  tremolo_world* world_of(const tremolo_scene* scene, std::uint32_t threads = 1) {
    tremolo_world* world = nullptr;
    EXPECT_EQ(tremolo_world_create(scene, threads, &world), TREMOLO_OK) << tremolo_last_error();
    return worlds_.emplace_back(world);
  }
  static std::vector<std::byte> saved(const tremolo_world* world) {
    std::size_t size = 0;
    EXPECT_EQ(tremolo_world_save(world, nullptr, 0, &size), TREMOLO_OK);
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(tremolo_world_save(world, bytes.data(), size, &size), TREMOLO_OK);
    return bytes;
  }
  static void advance(tremolo_world* world, int steps) {
    ASSERT_EQ(tremolo_world_step(world, steps, nullptr), TREMOLO_OK) << tremolo_last_error();
  }

  static inline std::string folder_;
  std::vector<tremolo_scene*> scenes_;
  std::vector<tremolo_world*> worlds_;
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
  tremolo_world* calls = world_of(by_calls());
  tremolo_world* of_file = world_of(file, 2);
  tremolo_world* of_text = world_of(text);
  for (int k = 0; k < 3; ++k) {
    for (tremolo_world* world : worlds_) advance(world, 40);
    EXPECT_TRUE(saved(calls) == saved(of_file)) << k;
    EXPECT_TRUE(saved(calls) == saved(of_text)) << k;
  }
  std::int64_t contacts = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const tremolo_body_id body = tremolo_world_body(calls, k);
    ASSERT_EQ(tremolo_world_contact(calls, body, &contacts, nullptr, nullptr, nullptr), TREMOLO_OK);
    EXPECT_GT(contacts, 0) << tremolo_world_name(calls, body);
  }
}

// A library continues a state that the program saved, and the program one of the library.
TEST_F(SceneCApi, StatesAreThoseOfThePrograms) {
  std::ofstream(path("scene.toml")) << kText;
  const ProgramResult run = run_program(
      folder_, TREMOLO_BIN_DIR "/tremolo run scene.toml --duration 0.1 --save end.saved");
  if (run.code == 127) GTEST_SKIP() << "the program is not built";
  ASSERT_EQ(run.code, 0) << run.err;
  tremolo_world* world = world_of(by_calls());
  advance(world, 50);
  const std::string bytes = testing::slurp(path("end.saved"));
  const std::vector<std::byte> own = saved(world);
  EXPECT_TRUE(std::string(reinterpret_cast<const char*>(own.data()), own.size()) == bytes);
  tremolo_world* other = world_of(by_calls());
  ASSERT_EQ(tremolo_world_restore(other, bytes.data(), bytes.size()), TREMOLO_OK)
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

// Hands and joints on bodies of all kinds; hand 2 begins and ends on the way.
const std::string kHeld = R"(
[[hands]]
body = "sheet"
at = "near:0.09,0.09,0.24"
stiffness = 20
damping = 0.05
[[hands.motion]]
kind = "glide"
velocity = [0.1, 0, 0.2]
start = 0
[[hands]]
body = "cube"
at = "near:0.05,0.05,0.05"
stiffness = 60
damping = 0.2
from = 0.02
until = 0.09
position = [0.1, 0.1, 0.3]
[[joints]]
body = "cube"
at = "near:-0.05,-0.05,0.05"
to = "sheet"
to-at = "top-left"
stiffness = 30
damping = 0.1
length = 0.1
[[joints]]
body = "hard"
at = "near:-0.05,0,0.05"
to = "cube"
stiffness = 40
length = 0.1
until = 0.07
)";

TEST_F(SceneCApi, HandsAndJointsOfAllKindsAreRestoredToTheBit) {
  tremolo_scene* scene = nullptr;
  ASSERT_EQ(tremolo_scene_parse((kText + kHeld).c_str(), path("held.toml").c_str(), &scene),
            TREMOLO_OK)
      << tremolo_last_error();
  keep(scene);
  for (const int before : {0, 5, 30, 40, 60}) {
    SCOPED_TRACE(before);
    tremolo_world* whole = world_of(scene);
    advance(whole, before);
    const std::vector<std::byte> bytes = saved(whole);
    tremolo_world* other = world_of(scene);
    ASSERT_EQ(tremolo_world_restore(other, bytes.data(), bytes.size()), TREMOLO_OK)
        << tremolo_last_error();
    advance(whole, 25);
    advance(other, 25);
    EXPECT_TRUE(saved(whole) == saved(other));
    // Back to an earlier moment, at which other hands and joints held.
    ASSERT_EQ(tremolo_world_restore(whole, bytes.data(), bytes.size()), TREMOLO_OK);
    advance(whole, 25);
    EXPECT_TRUE(saved(whole) == saved(other));
  }
}

// In each step what a body has gained is what gravity, contact, hands, joints and the rest gave.
TEST_F(SceneCApi, TheWorkOfHandsAndJointsIsInTheBalance) {
  tremolo_scene* scene = nullptr;
  ASSERT_EQ(tremolo_scene_parse((kText + kHeld).c_str(), path("held.toml").c_str(), &scene),
            TREMOLO_OK);
  tremolo_world* world = world_of(keep(scene));
  tremolo_body_id sheet = 0, cube = 0;
  ASSERT_EQ(tremolo_world_find(world, "sheet", &sheet), TREMOLO_OK);
  ASSERT_EQ(tremolo_world_find(world, "cube", &cube), TREMOLO_OK);
  tremolo_energy_account account{};
  for (int i = 0; i < 60; ++i) {
    advance(world, 1);
    ASSERT_EQ(tremolo_world_account(world, sheet, &account), TREMOLO_OK);
    ASSERT_LT(std::abs(account.remainder), 1e-10);
  }
  EXPECT_NE(account.hand, 0.0);
  EXPECT_NE(account.joint, 0.0);
  ASSERT_EQ(tremolo_world_account(world, cube, &account), TREMOLO_OK);
  EXPECT_NE(account.hand, 0.0);
  EXPECT_NE(account.joint, 0.0);
}

// A hand by calls has the bits of one of a scene.
TEST_F(SceneCApi, HandsByCallsAreThoseOfAScene) {
  const std::string hands = R"(
[[hands]]
body = "sheet"
at = 48
stiffness = 20
damping = 0.05
[[hands]]
body = "cube"
at = "vertex:0"
stiffness = 60
damping = 0.2
[[hands]]
body = "hard"
at = "vertex:1"
stiffness = 50
)";
  tremolo_scene *scene = nullptr, *bare = nullptr;
  ASSERT_EQ(tremolo_scene_parse((kText + hands).c_str(), path("hands.toml").c_str(), &scene),
            TREMOLO_OK)
      << tremolo_last_error();
  ASSERT_EQ(tremolo_scene_parse(kText.c_str(), path("bare.toml").c_str(), &bare), TREMOLO_OK);
  tremolo_world *wanted = world_of(keep(scene)), *world = world_of(keep(bare));
  struct Held {
    const char* body;
    std::uint32_t vertex;
    double stiffness, damping;
  };
  for (const Held& held :
       {Held{"sheet", 48, 20.0, 0.05}, {"cube", 0, 60.0, 0.2}, {"hard", 1, 50.0, 0.0}}) {
    tremolo_body_id body = 0;
    std::uint64_t hand = 99;
    ASSERT_EQ(tremolo_world_find(world, held.body, &body), TREMOLO_OK);
    ASSERT_EQ(tremolo_world_grab(world, body, held.vertex, held.stiffness, held.damping, &hand),
              TREMOLO_OK)
        << tremolo_last_error();
  }
  advance(wanted, 40);
  advance(world, 40);
  for (std::size_t k = 0; k < tremolo_world_bodies(world); ++k) {
    const tremolo_body_id body = tremolo_world_body(world, k);
    std::vector<double> a(3 * tremolo_world_vertices(world, body)), b(a.size());
    ASSERT_EQ(tremolo_world_positions_double(wanted, body, a.data(), a.size()), TREMOLO_OK);
    ASSERT_EQ(tremolo_world_positions_double(world, body, b.data(), b.size()), TREMOLO_OK);
    EXPECT_TRUE(a == b) << body;
  }
  tremolo_body_id sheet = 0;
  double force[3] = {0.0, 0.0, 0.0};
  const double far[3] = {0.2, 0.2, 0.5};
  ASSERT_EQ(tremolo_world_find(world, "sheet", &sheet), TREMOLO_OK);
  ASSERT_EQ(tremolo_world_move_hand(world, sheet, 0, far), TREMOLO_OK);
  advance(world, 1);
  ASSERT_EQ(tremolo_world_hand_force(world, sheet, 0, force), TREMOLO_OK);
  EXPECT_GT(force[2], 1.0);
  EXPECT_EQ(tremolo_world_hand_force(world, sheet, 1, force), TREMOLO_USAGE) << "the cube's";
  ASSERT_EQ(tremolo_world_let_go(world, sheet, 0), TREMOLO_OK);
  EXPECT_EQ(tremolo_world_let_go(world, sheet, 0), TREMOLO_USAGE);
  std::uint64_t hand = 0;
  EXPECT_EQ(tremolo_world_grab(world, sheet, 49, 1.0, 0.0, &hand), TREMOLO_CONTENT);
  EXPECT_EQ(tremolo_world_grab(world, sheet, 5, -1.0, 0.0, &hand), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_world_grab(world, sheet, 6, 1.0, 0.0, &hand), TREMOLO_USAGE) << "a pin";
}

TEST_F(SceneCApi, WrongHandsAndJointsAreToldWithTheirLine) {
  const std::pair<const char*, const char*> wrong[] = {
      {"[[hands]]\nbody = \"shett\"\nat = 1\nstiffness = 1\n", "there is no body 'shett'"},
      {"[[hands]]\nbody = \"sheet\"\nat = 49\nstiffness = 1\n", "there is no particle 49"},
      {"[[hands]]\nbody = \"sheet\"\nat = 0\nstiffness = 1\n", "it is fixed"},
      {"[[hands]]\nbody = \"sheet\"\nat = \"corners\"\nstiffness = 1\n", "4 particles"},
      {"[[hands]]\nbody = \"cube\"\nat = 13\nstiffness = 1\n", "vertex 13 is inside"},
      {"[[hands]]\nbody = \"cube\"\nat = 27\nstiffness = 1\n", "there is no vertex 27"},
      {"[[hands]]\nbody = \"cube\"\nat = 1\nstiffness = -1\n", "must be positive"},
      {"[[hands]]\nbody = \"cube\"\nat = 1\nstiffness = nan\n", "stiffness"},
      {"[[hands]]\nbody = \"cube\"\nat = 1\nstiffness = 1\ndamping = -1\n", "negative"},
      {"[[joints]]\nbody = \"cube\"\nat = 1\nto = \"shett\"\n", "there is no body 'shett'"},
      {"[[joints]]\nbody = \"cube\"\nat = 1\nto = \"sheet\"\nto-at = 99\n",
       "there is no particle 99"},
      {"[[joints]]\nbody = \"cube\"\nat = 1\nto = \"sheet\"\nto-at = 1\n", "apart at the start"},
      // 3.6 mm too short: less than the sheet's margin and more than the box's.
      {"[[joints]]\nbody = \"sheet\"\nat = \"top-left\"\nto = \"hard\"\n"
       "to-at = \"near:-0.05,0.05,0.05\"\nlength = 0.1431\n",
       "0.146684 m apart at the start"},
      {"[[joints]]\nbody = \"cube\"\nat = 1\nto = \"sheet\"\nlength = -1\n", "negative"}};
  for (const auto& [text, told] : wrong) {
    SCOPED_TRACE(text);
    tremolo_scene* scene = nullptr;
    tremolo_status found =
        tremolo_scene_parse((kText + text).c_str(), path("wrong.toml").c_str(), &scene);
    if (found == TREMOLO_OK) {
      tremolo_world* world = nullptr;
      found = tremolo_world_create(keep(scene), 1, &world);
    }
    EXPECT_EQ(found, TREMOLO_CONTENT);
    const std::string message = tremolo_last_error();
    EXPECT_NE(message.find(told), std::string::npos) << message;
    EXPECT_NE(message.find(": line "), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace tremolo
