// `tremolo run` of scenes in which bodies of tetrahedra meet others: known answers, as a user meets
// them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

using nlohmann::json;

constexpr double kWeight = 9.81;  // N, of each cube of 1 kg

class MixedProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    models_ = testing::fresh_folder();
    TetMesh mesh = box_mesh({2, 2, 2}, {0.1, 0.1, 0.1});
    for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(0.05);
    testing::write_veg(models_ + "/cube.veg", mesh);
    for (const char* what :
         {"tets cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none -o cube.tets",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
          "--order 1 -o cube.tremolo"}) {
      const ProgramResult made = run_program(models_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override { folder_ = fresh_folder(); }

  static std::string tets(const std::string& name, const std::string& keys) {
    return "[[bodies]]\nname = \"" + name + "\"\nkind = \"tets\"\nmodel = \"" + models_ +
           "/cube.tets\"\n" + keys;
  }
  static std::string reduced(const std::string& name, const std::string& keys) {
    return "[[bodies]]\nname = \"" + name + "\"\nkind = \"free\"\nmodel = \"" + models_ +
           "/cube.tremolo\"\nshape = \"box\"\nhalf-extents = [0.05, 0.05, 0.05]\n" + keys;
  }
  static std::string rigid(const std::string& name, const std::string& keys) {
    return "[[bodies]]\nname = \"" + name +
           "\"\nkind = \"rigid\"\nmass = 1\nshape = \"box\"\nhalf-extents = [0.05, 0.05, 0.05]\n" +
           keys;
  }

  ProgramResult run(const std::string& scene, const std::string& flags = "--json") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + "run scene.toml " + flags);
  }

  static inline std::string models_;
  std::string folder_;
};

// Contact gives to one body what it takes from the other, except for friction and restitution.
double contact_sum(const json& report) {
  double sum = 0.0;
  for (const json& body : report["bodies"]) sum += body["energy_by_cause"]["contact"].get<double>();
  return sum;
}

const std::string kFloor = "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.5\n";

TEST_F(MixedProgram, ABlockOfTetrahedraRestsWithItsWeightOnARigidAndOnAReducedOne) {
  for (const bool is_rigid : {true, false}) {
    const std::string below = "position = [0, 0, 0.0503]\nrestitution = 0\nfriction = 0.5\n";
    const ProgramResult result =
        run("step = 0.002\nduration = 0.5\ngravity = [0, 0, -9.81]\n" +
            (is_rigid ? rigid("lower", below)
                      : reduced("lower", below + "alpha = 30\nbeta = 0.005\n")) +
            tets("upper",
                 "position = [0, 0, 0.1506]\nrestitution = 0\nfriction = 0.5\n"
                 "degree = \"quadratic\"\nintegrator = \"implicit-euler\"\nbeta = 0.005\n") +
            kFloor);
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    const json& upper = report["bodies"][1];
    EXPECT_EQ(upper["kind"], "tets");
    EXPECT_NEAR(upper["contact_force_final"][2].get<double>(), kWeight, 1e-3 * kWeight);
    EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
    // Of the 0.02 J that gravity gives.
    EXPECT_LE(std::abs(contact_sum(report)), 1e-9);
  }
}

TEST_F(MixedProgram, APairThatCollidesKeepsBothMomenta) {
  const std::string method = "degree = \"quadratic\"\nintegrator = \"midpoint\"\n";
  const ProgramResult result = run(
      "step = 0.001\nduration = 0.15\n" +
      reduced("left",
              "position = [-0.09, 0.01, -0.02]\nvelocity = [1, 0.2, 0]\nspin = [2, 5, "
              "-1]\n") +
      rigid("below", "position = [0.09, -0.01, -0.2]\nvelocity = [0, 0, 1.2]\n") +
      tets("right", method + "position = [0.09, -0.01, 0.03]\nvelocity = [-0.8, 0, 0.1]\nspin = "
                             "[-3, 1, 4]\n"));
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  for (const char* which : {"linear_momentum", "angular_momentum"})
    for (int axis = 0; axis < 3; ++axis) {
      double change = 0.0;
      for (const json& body : report["bodies"])
        change += body[which + std::string("_final")][axis].get<double>() -
                  body[which + std::string("_initial")][axis].get<double>();
      // Of momenta of 1 kg m/s and 0.1 N m s each.
      EXPECT_LE(std::abs(change), 3e-10) << which << axis;
    }
  EXPECT_LE(std::abs(contact_sum(report)), 1e-9);
  EXPECT_GT(report["bodies"][2]["contacts"].get<int>(), 0);
}

// Gravity is tilted instead of the floor; mu is the geometric mean of 0.3 and 0.3.
TEST_F(MixedProgram, ABlockSticksBelowTheAngleOfFrictionAndSlidesAboveIt) {
  const auto momentum = [this](double slope, double duration) {
    const double angle = slope * std::atan(0.3);
    const ProgramResult result = run(
        "step = 0.001\nduration = " + std::to_string(duration) + "\ngravity = [" +
        std::to_string(kWeight * std::sin(angle)) + ", 0, " +
        std::to_string(-kWeight * std::cos(angle)) + "]\n" +
        tets("block",
             "position = [0, 0, 0.0502]\nrestitution = 0\nfriction = 0.3\n"
             "degree = \"linear\"\nintegrator = \"implicit-euler\"\nbeta = 0.005\n") +
        rigid("far", "position = [0, 5, 0.0502]\nrestitution = 0\nfriction = 0.3\n") +
        "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.3\nrestitution = 0\n");
    EXPECT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    std::array<double, 2> speeds{};
    for (const json& body : report["bodies"])
      speeds[body["kind"] == "tets" ? 0 : 1] = body["linear_momentum_final"][0].get<double>();
    return speeds;
  };
  // m/s, of 1 kg: rounding and the end of the elastic ring.
  EXPECT_LT(std::abs(momentum(0.95, 0.6)[0]), 1e-6);
  const double angle = 1.5 * std::atan(0.3);
  const double slide = kWeight * (std::sin(angle) - 0.3 * std::cos(angle));
  const auto early = momentum(1.5, 0.2), late = momentum(1.5, 0.4);
  for (const std::size_t kind : {0U, 1U})
    EXPECT_NEAR((late[kind] - early[kind]) / 0.2, slide, 5e-3 * slide) << kind;
}

// A scene of tetrahedra alone is a world too, if a collider moves.
TEST_F(MixedProgram, ABlockAloneIsDraggedByAFloorThatBeginsToGlide) {
  const ProgramResult result = run(
      "step = 0.002\nduration = 0.4\ngravity = [0, 0, -9.81]\n" +
      tets("block",
           "position = [0, 0, 0.0502]\nrestitution = 0\nfriction = 0.3\n"
           "degree = \"linear\"\nintegrator = \"implicit-euler\"\nbeta = 0.005\n") +
      "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.3\nrestitution = 0\n"
      "[[colliders.motion]]\nkind = \"glide\"\nvelocity = [1, 0, 0]\nstart = 0.2\nramp = 0.02\n");
  ASSERT_EQ(result.code, 0) << result.err;
  const json block = json::parse(result.out)["bodies"][0];
  // For the last 0.2 s, less 2 ms until the block's bottom and friction have bent.
  const double momentum = block["linear_momentum_final"][0].get<double>();
  EXPECT_NEAR(momentum, 0.3 * kWeight * 0.2, 0.3 * kWeight * 0.004);
  EXPECT_NEAR(block["contact_force_final"][0].get<double>(), 0.3 * kWeight, 0.02 * kWeight);
}

// Where edges become quadratic or linear, surfaces in contact jump. The energy that contact has
// from that is given, and no error of the balance.
TEST_F(MixedProgram, BalancesCloseWhereEdgesInContactChangeTheirDegree) {
  const ProgramResult result =
      run("step = 0.001\nduration = 0.4\ngravity = [0, 0, -9.81]\n" +
          reduced("upper", "position = [0.02, 0.01, 0.17]\nvelocity = [0, 0, -2]\n") +
          tets("lower", "position = [0, 0, 0.0503]\n") + kFloor);
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_GT(report["bodies"][1]["edges_switched"].get<int>(), 10);
  for (const json& body : report["bodies"]) {
    EXPECT_LE(body["energy_balance_error"].get<double>(), 1e-9) << body["body"];
    EXPECT_LE(std::abs(body["contact_error"].get<double>()), 1e-9) << body["body"];
  }
}

TEST_F(MixedProgram, WritesTablesAndSurfacesOfEachBody) {
  const ProgramResult result =
      run("step = 0.002\nduration = 0.02\ngravity = [0, 0, -9.81]\n" + rigid("lower", "") +
              tets("upper", "position = [0, 0, 0.2]\ncopies = [1, 1, 2]\nspacing = [0, 0, 0.2]\n"),
          "--out out --surfaces 2 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  ASSERT_EQ(report["bodies"].size(), 3U);
  EXPECT_EQ(report["bodies"][2]["body"], "upper-2");
  for (const char* name : {"lower", "upper-1", "upper-2"}) {
    const std::string folder = folder_ + "/out/" + name;
    EXPECT_TRUE(std::ifstream(folder + "/run.csv").good()) << name;
    EXPECT_TRUE(std::ifstream(folder + "/frames.csv").good()) << name;
  }
}

// Heights of the vertices' mean, m, of all frames of a point cache (PC2).
std::vector<double> heights_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 12> name{};
  std::array<std::int32_t, 2> version_points{};
  std::array<float, 2> start_rate{};
  std::int32_t frames = 0;
  file.read(name.data(), 12);
  file.read(reinterpret_cast<char*>(version_points.data()), 8);
  file.read(reinterpret_cast<char*>(start_rate.data()), 8);
  file.read(reinterpret_cast<char*>(&frames), 4);
  std::vector<double> heights;
  std::vector<float> values(file ? 3 * static_cast<std::size_t>(version_points[1]) : 0);
  for (std::int32_t f = 0; f < frames && !values.empty(); ++f) {
    file.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(sizeof(float) * values.size()));
    double sum = 0.0;
    for (std::size_t i = 2; i < values.size(); i += 3) sum += values[i];
    heights.push_back(file ? 3.0 * sum / static_cast<double>(values.size()) : NAN);
  }
  return heights;
}

// A cube of tetrahedra and a sheet by the midpoint rule, which has the exact path of a fall, and a
// rigid box: the film has all of them where gravity takes them.
// g t^2/2, whatever the turn of the body, for a probe of the scene and one of the command line.
TEST_F(MixedProgram, ProbesOfTetrahedraAndClothFall) {
  const std::string scene =
      "duration = 0.4\nstep = 0.004\ngravity = [0, 0, -9.81]\n" +
      tets("cube",
           "integrator = \"midpoint\"\nposition = [0.3, 0.2, 5]\nturn = [0, 0, 1, 30]\n"
           "probe = \"near:0.05,0.05,0.05\"\n") +
      "[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\nintegrator = \"midpoint\"\ndrag = 0\n"
      "columns = 5\nrows = 5\nwidth = 0.2\nheight = 0.2\ncorner = [1, 0, 5]\n"
      "probe = [\"12\", \"top-left\"]\n";
  const auto ways_at_end = [&](const std::string& name) {
    const std::vector<std::string> lines =
        testing::all_lines(testing::slurp(folder_ + "/out/" + name + "/run.csv"));
    const std::size_t first = lines[0].find(",u");
    EXPECT_NE(first, std::string::npos) << lines[0];
    const auto before = std::count(lines[0].begin(), lines[0].begin() + first + 1, ',');
    std::vector<double> values;
    std::istringstream row(lines.back());
    std::string cell;
    for (std::ptrdiff_t k = 0; std::getline(row, cell, ','); ++k)
      if (k >= before) values.push_back(std::stod(cell));
    return values;
  };
  const double fallen = -0.5 * 9.81 * 0.16;
  for (const bool flag : {false, true}) {
    const ProgramResult result = run(scene, flag ? "--out out --probe 0" : "--out out");
    ASSERT_EQ(result.code, 0) << result.err;
    for (const std::string name : {"cube", "sheet"}) {
      const std::vector<double> ways = ways_at_end(name);
      ASSERT_EQ(ways.size(), !flag && name == "sheet" ? 6U : 3U) << name;
      for (std::size_t k = 0; k < ways.size(); ++k)
        EXPECT_NEAR(ways[k], k % 3 == 2 ? fallen : 0.0, 1e-8) << name << k;
    }
  }
  const ProgramResult refused = run(scene, "--probe 13");
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("body 'cube': probe = \"13\""), std::string::npos) << refused.err;
}

// A load presses a block of tetrahedra on a rigid box: the box carries m g + F, the floor both.
TEST_F(MixedProgram, ALoadedBlockPressesWithItsWeightAndItsLoad) {
  const ProgramResult result = run(
      "step = 0.002\nduration = 0.5\ngravity = [0, 0, -9.81]\n" +
      rigid("lower", "position = [0, 0, 0.0503]\nrestitution = 0\nfriction = 0.5\n") +
      tets("upper",
           "position = [0, 0, 0.1506]\nrestitution = 0\nfriction = 0.5\ndegree = \"quadratic\"\n"
           "integrator = \"implicit-euler\"\nbeta = 0.005\n[[bodies.loads]]\nload = \"constant\"\n"
           "at = \"z>99%\"\nforce = [0, 0, -4]\n[[bodies.loads]]\nload = \"ramp\"\n"
           "load-duration = 0.1\nat = \"z>99%\"\nforce = [0, 0, -3]\nscale = 2\n") +
      kFloor);
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  const json& upper = report["bodies"][1];
  EXPECT_NEAR(upper["contact_force_final"][2].get<double>(), kWeight + 10.0, 1e-3 * (kWeight + 10));
  EXPECT_GT(upper["energy_by_cause"]["load"].get<double>(), 0.0);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
}

// Scenes of tetrahedra alone that have loads, or gravity that changes, are worlds.
TEST_F(MixedProgram, ABlockAloneHasALoadAndGravityInTime) {
  const ProgramResult result =
      run("step = 0.002\nduration = 0.2\ngravity = [[0, 0, 0, -2], [0.1, 0, 0, -4]]\n" +
          tets("block",
               "integrator = \"midpoint\"\nload = \"square\"\nload-duration = 0.0333\n"
               "at = \"x>99%\"\nforce = [3, 0, 0]\n") +
          tets("other", "position = [0, 0, 1]\n"));
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  const json& block = report["bodies"][0];
  EXPECT_NEAR(block["linear_momentum_final"][0].get<double>(), 0.0999, 1e-8);
  EXPECT_NEAR(block["linear_momentum_final"][2].get<double>(), -0.7, 1e-8);
  EXPECT_NEAR(block["energy_by_cause"]["gravity"].get<double>(), 0.5 * 0.49, 1e-9);
  EXPECT_NEAR(report["bodies"][1]["linear_momentum_final"][2].get<double>(), -0.7, 1e-8)
      << "bdf2 has no lag";
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-8);
}

TEST_F(MixedProgram, ASceneOfClothAloneSaysWhereItsLoadsBelong) {
  const ProgramResult result = run(
      "step = 0.01\nduration = 0.1\n[[cloths]]\ncolumns = 4\nrows = 4\nload = \"sine\"\nat = 3\n"
      "force = [0, 0, 1]\n");
  EXPECT_EQ(result.code, 3);
  EXPECT_NE(result.err.find("kind = \"cloth\""), std::string::npos) << result.err;
}

TEST_F(MixedProgram, AFilmHasBodiesOfEveryKindWhereTheyFall) {
  std::ofstream(folder_ + "/scene.toml")
      << "step = 0.002\nduration = 0.1\ngravity = [0, 0, -9.81]\n" +
             rigid("box", "position = [0, 0, 1]\n") +
             tets("cube", "position = [1, 0, 1]\nintegrator = \"midpoint\"\n") +
             "[[bodies]]\nname = \"sheet\"\nkind = \"cloth\"\ncolumns = 4\nrows = 4\n"
             "corner = [3, 0, 1]\nintegrator = \"midpoint\"\ndrag = 0\n";
  const ProgramResult made =
      run_program(folder_, kTremolo + "export scene.toml --rate 50 --pc2 film.pc2");
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* name : {"box", "cube", "sheet"}) {
    const std::vector<double> heights = heights_of(folder_ + "/film-" + std::string(name) + ".pc2");
    ASSERT_EQ(heights.size(), 6U) << name;
    for (std::size_t f = 0; f < heights.size(); ++f) {
      const double t = 0.02 * static_cast<double>(f);
      EXPECT_NEAR(heights[f], 1.0 - 0.5 * 9.81 * t * t, 1e-6) << name << " " << t;  // floats
    }
  }
}

// A soft duck falls on another, and both onto the floor. Points of one stick to the other, whose
// normals are smooth although the gradient of the distance is not.
TEST_F(MixedProgram, DucksOnEachOtherSettleAsTheStepIsHalved) {
  const auto duck = [](const std::string& name, const std::string& position) {
    return "[[bodies]]\nname = \"" + name +
           "\"\nkind = \"tets\"\nmodel = \"" TREMOLO_BIN_DIR
           "/../models/duck.tets\"\nrestitution = 1\nposition = " +
           position + "\n";
  };
  const auto causes = [&](const std::string& step) {
    const ProgramResult result =
        run("step = " + step + "\nduration = 0.6\ngravity = [0, 0, -9.81]\n" +
            duck("low", "[0, 0, 0.15]") + duck("high", "[0.03, 0, 0.4]") +
            rigid("far", "position = [5, 0, 0.06]\n") +
            "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nrestitution = 1\n");
    EXPECT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    std::vector<json> found;
    for (const json& body : report["bodies"])
      if (body["kind"] == "tets") found.push_back(body["energy_by_cause"]);
    return found;
  };
  const std::vector<json> coarse = causes("0.004"), fine = causes("0.002");
  ASSERT_EQ(coarse.size(), 2U);
  ASSERT_EQ(fine.size(), 2U);
  for (const std::size_t i : {0U, 1U}) {
    const double given = fine[i]["contact"];  // 0.89 J
    EXPECT_NEAR(coarse[i]["contact"].get<double>(), given, 0.1 * std::abs(given));
    // What is beyond the surface counts as restitution, which takes none here: it is lost.
    for (const json& run : {coarse[i], fine[i]}) {
      EXPECT_LE(run["restitution"].get<double>(), 1e-9);
      EXPECT_GE(run["restitution"].get<double>(), -0.002);
    }
  }
}

TEST_F(MixedProgram, RefusesByNameWhatABodyOfTetrahedraCannotDo) {
  const std::string start = "step = 0.002\nduration = 0.02\n" + rigid("other", "");
  struct Refusal {
    std::string scene, flags, words;
    int code;
  };
  const std::string block = tets("block", "position = [0, 0, 0.3]\n");
  for (const Refusal& refusal :
       {Refusal{
            start + block + "[[hands]]\nbody = \"block\"\nat = \"vertex:99999\"\nstiffness = 10\n",
            "", "hand 1: at = \"vertex:99999\"", 3},
        {start + block + "creep = 0.01\n", "", "without creep", 3},
        {start + block + "load = \"constant\"\nat = \"13\"\nforce = [0, 0, 1]\n", "",
         "vertex 13 is inside", 3},
        {start + block + "load = \"constant\"\n", "", "needs `at` and `force`", 3},
        {start + block + block, "", "two bodies", 3},
        {start + tets("block", "position = [0, 0, 0.05]\n"), "", "inside body 'other'", 3},
        {start + block, "--integrator ep4", "--integrator", 2}}) {
    const ProgramResult result = run(refusal.scene, refusal.flags);
    EXPECT_EQ(result.code, refusal.code) << refusal.words << result.err;
    EXPECT_NE(result.err.find(refusal.words), std::string::npos) << result.err;
  }
  std::ofstream(folder_ + "/scene.toml") << start + block;
  const ProgramResult inspected = run_program(folder_, kTremolo + "inspect scene.toml --json");
  EXPECT_EQ(inspected.code, 0) << inspected.err;
  EXPECT_EQ(json::parse(inspected.out)["bodies"].size(), 2U);
}

}  // namespace
}  // namespace tremolo
