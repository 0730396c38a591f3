// Scenes of bodies of tetrahedra as a user meets them: a bar and a floor made here, and bad input.
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

using nlohmann::json;

class TetsProgram : public ::testing::Test {
 protected:
  // A rubber cube of 0.1 m, which nothing holds.
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/cube.veg", box_mesh({2, 2, 2}, {0.1, 0.1, 0.1}));
    const ProgramResult made = run_program(
        folder_, kPrecompute +
                     "tets cube.veg -o cube.tets --young 1e5 --poisson 0.4 --density 1000 "
                     "--fix none --cells 20");
    ASSERT_EQ(made.code, 0) << made.err;
  }

  ProgramResult run(const std::string& scene, const std::string& flags = "") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + "run scene.toml " + flags);
  }
  static std::string cube(const std::string& name, double height, const std::string& keys = "") {
    return "[[bodies]]\nname = \"" + name +
           "\"\nkind = \"tets\"\nmodel = \"cube.tets\"\nintegrator = \"implicit-euler\"\n"
           "alpha = 2.0\ntangent = \"frozen\"\nunsolved = \"take\"\nmax-iterations = 4\nposition = "
           "[0, 0, " +
           std::to_string(height) + "]\n" + keys;
  }
  static std::string scene(double duration, const std::string& bodies) {
    return "step = 0.01\nduration = " + std::to_string(duration) + "\ngravity = [0, 0, -9.81]\n" +
           bodies + "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n";
  }

  std::string folder_;
};

TEST_F(TetsProgram, ACubeFallsOnAnotherAndWhatScriptsRelyOnIsTold) {
  const ProgramResult result =
      run(scene(1.0, cube("low", 0.001) + cube("high", 0.121, "degree = \"quadratic\"\n")),
          "--json --out out --surfaces 3");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["steps"], 100);
  EXPECT_NEAR(report["reached"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(report["exit_code"], 0);
  EXPECT_EQ(report["reason"], nullptr);
  EXPECT_LE(report["bodies"][0]["elastic_momentum_error"].get<double>(), 1e-12);
  for (const char* key : {"elements", "quadratic_edges_share", "microseconds_per_step",
                          "frames_per_second", "memory_bytes"})
    EXPECT_GT(report[key].get<double>(), 0.0) << key;
  const json &low = report["bodies"][0], &high = report["bodies"][1];
  EXPECT_NEAR(low["mass"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(high["quadratic_edges_share"], 1.0);
  // Both began in the air, and lie on each other.
  EXPECT_EQ(low["contact_points_initial"], 0);
  EXPECT_EQ(result.err.find("begins in contact"), std::string::npos) << result.err;
  EXPECT_GT(low["contact_points_final"].get<int>(), 0);
  EXPECT_LE(low["largest_jump_of_switches"].get<double>(), 1e-3);
  EXPECT_EQ(low["elements_inverted_most"], 0);
  EXPECT_EQ(low["elements_inverted_final"], 0);
  // The upper one has fallen by the gaps below it, 0.02 m, and by what both are pressed in.
  const double fallen = (high["energies_initial"]["gravity"].get<double>() -
                         high["energies_final"]["gravity"].get<double>()) /
                        (9.81 * high["mass"].get<double>());
  EXPECT_GT(fallen, 0.020);
  EXPECT_LT(fallen, 0.037);
  EXPECT_FALSE(slurp(folder_ + "/out/high/run.csv").empty());
}

TEST_F(TetsProgram, TheReportHasWhatAMethodLosesOfTheSpin) {
  const auto report_of = [this](const std::string& method) {
    const ProgramResult result =
        run("step = 0.01\nduration = 1.0\n[[bodies]]\nname = \"one\"\nkind = \"tets\"\nmodel = "
            "\"cube.tets\"\nintegrator = \"" +
                method + "\"\nspin = [0, 8, 0]\n",
            "--json");
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out);
  };
  const json euler = report_of("implicit-euler"), midpoint = report_of("midpoint");
  const json& body = euler["bodies"][0];
  const double before = body["angular_momentum_initial"][1].get<double>();
  const double after = body["angular_momentum_final"][1].get<double>();
  // A cube of 1 kg and 0.1 m: m a^2 / 6 times 8 rad/s.
  EXPECT_NEAR(before, 1.0 * 0.01 / 6.0 * 8.0, 1e-9);
  // Implicit Euler rotates by x1 = x0 + h v1: of a rigid body L falls by 1 / (1 + (h w)^2) a step.
  EXPECT_LT(after, 0.8 * before);
  EXPECT_GE(euler["momentum_error"].get<double>(), body["angular_momentum_lost"].get<double>());
  EXPECT_GT(body["angular_momentum_lost"].get<double>(), 0.1);
  EXPECT_LE(midpoint["momentum_error"].get<double>(), 1e-12);
}

TEST_F(TetsProgram, AnEnergyThatNobodyPutInEndsTheRun) {
  // One correction a step, unchecked, of a cube that rotates by three radians in a step.
  const ProgramResult result =
      run("step = 0.01\nduration = 1.0\n[[bodies]]\nname = \"one\"\nkind = \"tets\"\nmodel = "
          "\"cube.tets\"\nintegrator = \"implicit-euler\"\ntangent = \"frozen\"\nunsolved = "
          "\"take\"\nmax-iterations = 1\nspin = [0, 300, 0]\n",
          "--json");
  EXPECT_EQ(result.code, 5) << result.out << result.err;
  EXPECT_NE(result.err.find("put in"), std::string::npos) << result.err;
  EXPECT_EQ(json::parse(result.out)["exit_code"], 5);
}

TEST_F(TetsProgram, ABodyThatBeginsInContactIsToldByName) {
  const ProgramResult floor = run(scene(0.02, cube("sunk", -0.01)), "--json");
  ASSERT_EQ(floor.code, 0) << floor.err;
  EXPECT_NE(floor.err.find("body 'sunk' begins in contact"), std::string::npos) << floor.err;
  EXPECT_NEAR(json::parse(floor.out)["bodies"][0]["penetration_initial"].get<double>(), 0.01, 1e-9);
  const ProgramResult other = run(scene(0.02, cube("a", 0.3) + cube("b", 0.385)), "--json");
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_NE(other.err.find("body 'a' begins in contact"), std::string::npos) << other.err;
  // Distances at rest are kept on a grid of twenty cells along the cube.
  EXPECT_NEAR(json::parse(other.out)["bodies"][1]["penetration_initial"].get<double>(), 0.015,
              0.002);
}

// The positions of a .ply that tremolo wrote: x, y, z in floats behind the head.
std::vector<float> ply_places(const std::string& path, std::size_t vertices) {
  const std::string text = slurp(path);
  const std::size_t head = text.find("end_header\n");
  EXPECT_NE(head, std::string::npos) << path;
  // Each vertex may have other properties besides its position: the number of its bytes.
  const bool normals = text.find("property float nx") < head;
  std::vector<float> places(3 * vertices);
  for (std::size_t i = 0; i < vertices; ++i)
    std::memcpy(&places[3 * i], text.data() + head + 11 + i * (normals ? 24 : 12), 12);
  return places;
}

TEST_F(TetsProgram, OtherProgramsOpenTheMotionOfARun) {
  const std::string made =
      scene(0.5, cube("low", 0.001) + cube("high", 0.15, "spin = [3, 1, 0]\n"));
  ASSERT_EQ(run(made, "--out out --surfaces 1").code, 0);
  const ProgramResult result = run_program(
      folder_, kTremolo +
                   "export scene.toml --rate 100 --from 0.5 --to 0.5 --pc2 a.pc2 --pvd c.pvd "
                   "--usda d.usda --glb e.glb --page f.html --json");
  ASSERT_EQ(result.code, 0) << result.err;
  // One frame, the last state: the exported vertices are those of the run's surface.
  const std::string cache = slurp(folder_ + "/a-high.pc2");
  ASSERT_GT(cache.size(), 32U);
  const std::size_t vertices = (cache.size() - 32) / 12;
  const std::vector<float> drawn =
      ply_places(folder_ + "/out/high/surface-0000-t0.500000s.ply", vertices);
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    float value = 0.0F;
    std::memcpy(&value, cache.data() + 32 + 4 * i, 4);
    ASSERT_NEAR(value, drawn[i], 1e-6) << i;
  }
  for (const char* file : {"/c.pvd", "/d.usda", "/e.glb", "/f.html"})
    EXPECT_FALSE(slurp(folder_ + file).empty()) << file;
  EXPECT_EQ(
      run_program(folder_, kTremolo + "export scene.toml --page a.html --live x.tremolo").code, 2);
}

TEST_F(TetsProgram, AGlbHasTheWholeMotionToAThousandthOfTheSize) {
  std::ofstream(folder_ + "/scene.toml")
      << scene(0.5, cube("low", 0.001) + cube("high", 0.15, "spin = [3, 1, 0]\n"));
  const ProgramResult result =
      run_program(folder_, kTremolo + "export scene.toml --rate 50 --glb b.glb --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["frames"], 26);
  EXPECT_LE(report["files"][0]["recorded_modes_error"].get<double>(), 1e-3);
  EXPECT_LE(report["files"][0]["position_error"].get<double>(), 1e-4);
}

// The bodies of these scenes have unsolved = "take"; with "cut" there is nothing to warn of.
TEST_F(TetsProgram, StepsThatWereTakenUnsolvedAreWarnedOf) {
  const auto warned = [this](const std::string& keys) {
    const std::string body =
        "[[bodies]]\nname = \"one\"\nkind = \"tets\"\nmodel = \"cube.tets\"\nposition = [0, 0, "
        "0.02]\n";
    const ProgramResult result = run(scene(0.5, body + keys), "--json");
    EXPECT_EQ(result.code, 0) << result.err;
    const std::string list = json::parse(result.out)["warnings"].dump();
    return list.find("were solved") != std::string::npos &&
           list.find("unsolved = ") != std::string::npos;
  };
  EXPECT_TRUE(warned("unsolved = \"take\"\nmax-iterations = 1\n"));
  EXPECT_FALSE(warned("unsolved = \"cut\"\n"));
  EXPECT_FALSE(warned(""));
}

TEST_F(TetsProgram, FlagsOfReducedBodiesAreRefusedByTheirName) {
  const std::string flags =
      "--load none\n--frequency 2\n--sweep 1,2\n--load-duration 1\n--signal a.csv\n--at 1\n"
      "--force 0,0,1\n--scale 2\n--deflect 5%\n--start static\n--wav a.wav\n--listen 1\n"
      "--modes 2\n--linear\n--hull\n--rescale young=1e6\n--damping-ratio 1:0.1,9:0.1\n"
      "--newmark-beta 0.3\n--newmark-gamma 0.6\n--split thesis\n--safety 0.5\n"
      "--coordinate all\n--velocities\n--probe 1\n--plot --out made\n--save a\n--restore a\n"
      "--threads 2\n";
  for (const std::string& flag : testing::all_lines(flags)) {
    const ProgramResult result = run(scene(0.1, cube("one", 0.2)), flag);
    EXPECT_EQ(result.code, 2) << flag << "\n" << result.err;
    const std::string words = flag.substr(0, flag.find(' ')) + " does not apply to bodies";
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err << "\ninstead of " << words;
  }
}

TEST_F(TetsProgram, WhatASceneGetsWrongIsRefusedByItsKey) {
  for (const auto& [keys, words] : {std::pair{"degree = \"cubic\"\n", "cubic"},
                                    {"upper = 1e-4\nlower = 1e-3\n", "lower"},
                                    {"creep = 0.0\n", "creep"},
                                    {"friction = -1.0\n", "friction"},
                                    {"beta = [[0, 0], [1, 2]]\n", "for reduced bodies"},
                                    {"tolerance = 0.0\n", "tolerance"},
                                    {"colour = 3\n", "colour"}}) {
    const ProgramResult result = run(scene(0.1, cube("one", 0.2, keys)));
    EXPECT_EQ(result.code, 3) << keys << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("scene.toml"), std::string::npos) << result.err;
  }
  // The step is of the scene, as with bodies of other kinds.
  for (const auto& [step, words] : {std::pair{"0", "step must be positive and finite (s)"},
                                    {"-1", "step must be positive and finite (s)"},
                                    {"inf", "line 1: 'step' must be a finite number"}}) {
    const ProgramResult result = run("step = " + std::string(step) +
                                     "\nduration = 1\n[[bodies]]\nname = \"one\"\nkind = "
                                     "\"tets\"\nmodel = \"cube.tets\"\n");
    EXPECT_EQ(result.code, 3) << result.err;
    EXPECT_NE(result.err.find(std::string("scene.toml: ") + words), std::string::npos)
        << result.err;
  }
  // A collider's friction and restitution; a run of no step.
  for (const auto& [keys, words] : {std::pair{"friction = -1.0\n", "friction"},
                                    {"restitution = 1.5\n", "restitution"},
                                    {"restitution = -0.1\n", "restitution"},
                                    {"friction = nan\n", "friction"}}) {
    const ProgramResult result = run(scene(0.1, cube("one", 0.2)) + keys);
    EXPECT_EQ(result.code, 3) << keys << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
  // Next to a body of another kind.
  for (const char* keys : {"contact-modulus = 0\n", "contact-stiffness = 0\n",
                           "contact-margin = 0\n", "contact-margin = -1\n"}) {
    const ProgramResult result =
        run("step = 0.003\nduration = 0.1\n[[bodies]]\nname = \"ball\"\nkind = \"rigid\"\nshape = "
            "\"sphere\"\nradius = 0.1\nmass = 1\nposition = [5, 0, 0]\n[[bodies]]\nname = \"one\"\n"
            "kind = \"tets\"\nmodel = \"cube.tets\"\n" +
            std::string(keys));
    const std::string key(keys, std::string(keys).find(' '));
    EXPECT_EQ(result.code, 3) << keys << result.err;
    EXPECT_NE(result.err.find("line 14: body 'one': "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(key == "contact-modulus" ? "modulus" : key), std::string::npos)
        << result.err;
  }
  const ProgramResult short_run = run(scene(0.004, cube("one", 0.2)));
  EXPECT_EQ(short_run.code, 3) << short_run.err;
  EXPECT_NE(short_run.err.find("half a step"), std::string::npos) << short_run.err;
  const ProgramResult missing =
      run("step = 0.01\nduration = 0.1\n[[bodies]]\nname = \"one\"\nkind = \"tets\"\n"
          "model = \"no.tets\"\nmade-by = \"make it\"\n");
  EXPECT_NE(missing.code, 0);
  EXPECT_NE(missing.err.find("make it"), std::string::npos) << missing.err;
}

// A very soft cube that hangs on one corner, with a box on it: the step that fails names both, and
// the cube's elements that are inside out.
TEST_F(TetsProgram, AStepThatFailsNamesItsBodiesAndTheElementsInsideOut) {
  const ProgramResult made =
      run_program(folder_, kPrecompute +
                               "tets cube.veg -o soft.tets --young 3e3 --poisson 0.4 "
                               "--density 1000 --fix none --cells 20");
  ASSERT_EQ(made.code, 0) << made.err;
  const ProgramResult result =
      run("step = 0.003\nduration = 0.4\ngravity = [0, 0, -9.81]\n"
          "[[bodies]]\nname = \"soft\"\nkind = \"tets\"\nmodel = \"soft.tets\"\n"
          "degree = \"quadratic\"\n"
          "[[bodies]]\nname = \"box\"\nkind = \"rigid\"\nshape = \"box\"\n"
          "half-extents = [0.04, 0.03, 0.02]\nfriction = 0\nrestitution = 0\n"
          "position = [0.05, 0.05, 0.125]\n"
          "[[joints]]\nbody = \"soft\"\nat = \"near:0,0,0.1\"\nto = \"world\"\n");
  EXPECT_EQ(result.code, 4) << result.err;
  EXPECT_NE(result.err.find("tremolo: bodies 'box', 'soft': the step from"), std::string::npos)
      << result.err;
  EXPECT_NE(result.err.find("elements of 'soft' are inside out"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tremolo
