// `tremolo run` of scenes in which friction holds bodies or bodies push each other over, and what a
// run says about slip and momentum.
#include <array>
#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/samples/shipped_scene.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;
using testing::shipped_scene;

class GripProgram : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  // Runs the scene, which must end with 0.
  json run(const std::string& scene, const std::string& flags = "") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    const ProgramResult result = run_program(folder_, kTremolo + "run scene.toml --json " + flags);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? json::parse(result.out) : json();
  }

  std::string folder_;
};

std::array<double, 3> end_of(const json& body) {
  return body["position_final"].get<std::array<double, 3>>();
}

// Two fingers lift the ball by 20 cm until t = 2.2 s. It then stays where it is for a minute, to a
// micrometre, and where it is depends on the step by less than that.
TEST_F(GripProgram, ABallThatTwoFingersHoldDoesNotCreepInAMinute) {
  const std::string scene = shipped_scene("gripper");
  const json begun = run(scene, "--duration 3"), held = run(scene);
  const json fine = run(scene, "--duration 3 --step 0.001");
  ASSERT_FALSE(begun.is_null() || held.is_null() || fine.is_null());
  const json &ball = held["bodies"][0], &ball_begun = begun["bodies"][0];
  EXPECT_GT(end_of(ball)[2], 0.22);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(end_of(ball)[axis], end_of(ball_begun)[axis], 1e-6);
    EXPECT_NEAR(end_of(fine["bodies"][0])[axis], end_of(ball_begun)[axis], 1e-6);
  }
  EXPECT_LE(held["energy_balance_error"].get<double>(), 1e-6);
  EXPECT_LE(held["momentum_error"].get<double>(), 1e-10);
  // Held points bend by less than a millimetre; nothing else moved.
  EXPECT_GT(ball["slip_max"].get<double>(), 1e-6);
  EXPECT_LT(ball["slip_max"].get<double>(), 2e-3);
  // A body at rest costs few corrections: two thousand steps of the motion before it cost more.
  EXPECT_LT(ball["iterations_per_step"].get<double>(), 2.0);
}

// The first eleven bodies of the row: all fall, and then sleep.
TEST_F(GripProgram, ADominoTopplesARow) {
  std::string scene = shipped_scene("dominoes");
  const std::string many = "copies = [199, 1, 1]";
  ASSERT_NE(scene.find(many), std::string::npos);
  scene.replace(scene.find(many), many.size(), "copies = [10, 1, 1]");
  const json report = run(scene, "--duration 4");
  ASSERT_FALSE(report.is_null());
  ASSERT_EQ(report["bodies"].size(), 11U);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  for (const json& body : report["bodies"]) {
    EXPECT_LT(end_of(body)[2], 0.04) << body["body"];  // it stood with its centre at 0.05 m
    EXPECT_TRUE(body["asleep"].get<bool>()) << body["body"];
    EXPECT_LT(std::abs(end_of(body)[1]), 0.01) << body["body"];
  }
}

// A rigid block slides on a rigid plate that lies on a soft, clamped one; the momentum of block and
// plate comes from gravity, the floor and the clamped body alone.
TEST_F(GripProgram, EveryChangeOfMomentumHasACause) {
  const std::string block =
      "[[bodies]]\nname = \"block\"\nkind = \"rigid\"\nshape = \"box\"\nhalf-extents = [0.02, "
      "0.02, 0.02]\nmass = 0.5\nfriction = 0.3\nrestitution = 0.3\n";
  const std::string scene =
      "duration = 0.6\nstep = 0.002\ngravity = [0, 0, -9.81]\n" + block +
      "position = [0, 0, 0.15]\nvelocity = [0.5, 0, 0]\n"
      "[[bodies]]\nname = \"ball\"\nkind = \"free\"\nmodel = \"" TREMOLO_MODEL_DIR
      "/ball-free.tremolo\"\nshape = \"sphere\"\nradius = 0.03\nposition = [0, 0, 0.08]\n"
      "beta = 0.001\n"
      "[[bodies]]\nname = \"finger\"\nkind = \"driven\"\nmodel = \"" TREMOLO_MODEL_DIR
      "/finger.tremolo\"\nshape = \"box\"\nhalf-extents = [0.01, 0.03, 0.07]\n"
      "position = [0.12, 0, 0.075]\n"
      "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n";
  const json report = run(scene);
  ASSERT_FALSE(report.is_null());
  for (const json& body : report["bodies"]) EXPECT_GT(body["contacts"].get<int>(), 0);
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
}

}  // namespace
}  // namespace tremolo
