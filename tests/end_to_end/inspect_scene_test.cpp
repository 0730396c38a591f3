// `tremolo inspect SCENE`: positions, contacts, steps that resolve the vibration; keyframes.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

class InspectScene : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/cube.veg", box_mesh({2, 2, 2}, {0.2, 0.2, 0.2}));
    const std::string solid = "cube.veg --young 1e6 --poisson 0.3 --density 1000 --threads 1 ";
    ASSERT_EQ(run_program(folder_, kMayBeRoot + kPrecompute + solid +
                                       "-o cube.tremolo --fix none --linear-modes 4 --modes 8")
                  .code,
              0);
    ASSERT_EQ(
        run_program(folder_, kMayBeRoot + kPrecompute + "tets " + solid + "--fix none -o cube.tets")
            .code,
        0);
  }
  ProgramResult run(const std::string& words, const std::string& scene) {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + words);
  }
  nlohmann::json inspected(const std::string& scene) {
    const ProgramResult result = run("inspect scene.toml --json", scene);
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }
  static std::string floor(const std::string& more = "") {
    return "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n" + more;
  }
  std::string folder_;
};

const std::string kCube =
    "step = 0.01\nduration = 1\n[[bodies]]\nname = \"cube\"\nmodel = \"cube.tremolo\"\nkind = "
    "\"free\"\n";

TEST_F(InspectScene, OfAWorldSaysWhoIsWhereAndWhatIsInContact) {
  const nlohmann::json json = inspected(kCube + "position = [1, 2, 0.001]\n" + floor());
  ASSERT_EQ(json["bodies"].size(), 1u);
  EXPECT_NEAR(json["bodies"][0]["low"][2].get<double>(), 0.001, 1e-12);
  EXPECT_NEAR(json["bodies"][0]["high"][0].get<double>(), 1.2, 1e-12);
  EXPECT_GT(json["bodies"][0]["first_mode_hz"].get<double>(), 1.0);
  EXPECT_NEAR(json["bodies"][0]["steps_a_period"].get<double>() * 0.01 *
                  json["bodies"][0]["first_mode_hz"].get<double>(),
              1.0, 1e-9);
  ASSERT_EQ(json["contacts"].size(), 1u);
  EXPECT_EQ(json["contacts"][0]["collider"], "floor");
  EXPECT_NEAR(json["contacts"][0]["distance_m"].get<double>(), 0.001, 1e-9);
  EXPECT_TRUE(inspected(kCube + "position = [1, 2, 0.5]\n" + floor())["contacts"].empty());
}

TEST_F(InspectScene, OfTetrahedraAndOfBodiesByThemselvesToo) {
  const nlohmann::json tets = inspected(
      "step = 0.01\nduration = 1\n[[bodies]]\nname = \"a\"\nkind = \"tets\"\nmodel = "
      "\"cube.tets\"\n"
      "position = [0, 0, 0]\n[[bodies]]\nname = \"b\"\nkind = \"tets\"\nmodel = \"cube.tets\"\n"
      "position = [0, 0, 0.3]\n" +
      floor());
  EXPECT_EQ(tets["bodies"].size(), 2u);
  ASSERT_EQ(tets["contacts"].size(), 1u);
  EXPECT_EQ(tets["contacts"][0]["body"], "a");
  const nlohmann::json bodies =
      inspected("[one]\nmodel = \"cube.tremolo\"\nload = \"none\"\nstep = 0.05\n");
  EXPECT_EQ(bodies["bodies"][0]["name"], "one");
  EXPECT_EQ(bodies["warnings"].size(), 1u);  // the step does not follow the first mode
}

TEST_F(InspectScene, KeyframesAwayFromThePositionAreWarnedOfAndMayBeInTheWorld) {
  const std::string moved =
      "position = [0, 0, -1]\nmotion = { kind = \"keyframes\", keys = [[0, 0, 0, -1], [1, 0, 0, "
      "-2]]";
  const std::string cube = kCube + "position = [0, 0, 3]\n";
  const nlohmann::json relative = inspected(cube + floor(moved + " }\n"));
  EXPECT_NE(relative["warnings"].dump().find("1 m and 0 degrees away"), std::string::npos)
      << relative["warnings"];
  EXPECT_EQ(relative["colliders"][0]["position"][2], -2.0);
  const nlohmann::json absolute = inspected(cube + floor(moved + ", frame = \"world\" }\n"));
  EXPECT_EQ(absolute["warnings"].dump().find("keyframes"), std::string::npos);
  EXPECT_EQ(absolute["colliders"][0]["position"][2], -1.0);
  // The run says it as well.
  const ProgramResult result =
      run("run scene.toml --duration 0.05 --json", cube + floor(moved + " }\n"));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("frame = \"world\""), std::string::npos) << result.err;
}

TEST_F(InspectScene, AWorldFrameIsRefusedWhereNothingHasAPosition) {
  const ProgramResult result = run(
      "inspect scene.toml",
      kCube +
          "position = [0, 0, 3]\n[[hands]]\nbody = \"cube\"\nat = 0\nstiffness = 10\nmotion = { "
          "kind = \"keyframes\", frame = \"world\", keys = [[0, 0, 0, 0], [1, 0, 0, 1]] }\n");
  EXPECT_EQ(result.code, 3) << result.err;
  EXPECT_NE(result.err.find("frame"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
