// Scenes with [[cloths]] as a user meets them: those of assets/scenes, small ones, and bad input.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ClothProgram : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult run(const std::string& scene, const std::string& flags = "") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + "run scene.toml " + flags);
  }
  void expect_refused(const std::string& scene, const std::string& words,
                      const std::string& flags = "") {
    const ProgramResult result = run(scene, flags);
    EXPECT_NE(result.code, 0) << scene;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err << "\ninstead of " << words;
  }
  // Each scene is refused with the words next to it.
  void expect_refused(std::initializer_list<std::pair<std::string, std::string>> scenes) {
    for (const auto& [scene, words] : scenes) expect_refused(scene, words);
  }
  static std::string asset(const std::string& name) {
    return TREMOLO_SOURCE_DIR "/assets/scenes/" + name + ".toml";
  }

  std::string folder_;
};

// A sheet of 36 particles on two corners.
std::string small_sheet(const std::string& keys = "") {
  return "duration = 0.5\nstep = 0.016666666667\ngravity = [0, 0, -9.81]\n[[cloths]]\ncolumns = 6\n"
         "rows = 6\npins = [\"top-left\", \"top-right\"]\n" +
         keys;
}

TEST_F(ClothProgram, TellsWhatScriptsRelyOn) {
  const ProgramResult result = run(small_sheet(), "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["scene"], "scene.toml");
  EXPECT_EQ(report["particles"], 36);
  // 60 neighbours, 50 diagonals, 48 second neighbours.
  EXPECT_EQ(report["springs"], 158);
  EXPECT_EQ(report["steps"], 30);
  EXPECT_NEAR(report["reached"].get<double>(), 0.5, 1e-9);
  EXPECT_EQ(report["exit_code"], 0);
  EXPECT_EQ(report["reason"], nullptr);
  // No step is too long for implicit Euler.
  EXPECT_EQ(report["stability_limit_s"], nullptr);
  EXPECT_EQ(report["penetration_max"], 0.0);
  for (const char* key : {"energy_initial", "energy_final", "energy_max", "energy_balance_error",
                          "microseconds_per_step", "iterations_per_step", "cut_steps"})
    EXPECT_TRUE(report[key].is_number()) << key;
  for (const char* cause : {"wind", "support", "contact", "damping", "method"})
    EXPECT_TRUE(report["energy_by_cause"][cause].is_number()) << cause;
}

TEST_F(ClothProgram, TheEnergyThatIsToldAddsUp) {
  for (const char* method : {"energy", "implicit-euler", "midpoint", "bdf2"}) {
    const ProgramResult result =
        run(small_sheet(), std::string("--json --tolerance 1e-10 --integrator ") + method);
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    double external = 0.0;
    for (const auto& [cause, value] : report["energy_by_cause"].items())
      external += value.get<double>();
    const double change =
        report["energy_final"].get<double>() - report["energy_initial"].get<double>();
    // Sums of 30 steps in doubles.
    EXPECT_NEAR(change, external, 1e-11 * report["energy_max"].get<double>()) << method;
    // The energy added by the method itself is due to the error of its solve: 1e-10 of the load.
    if (std::string(method) == "energy") {
      EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
    }
  }
}

TEST_F(ClothProgram, WritesEnergiesAndASurfaceAFrame) {
  const ProgramResult result =
      run(small_sheet("name = \"sheet\"\n"), "--out made --every 10 --surfaces 3 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ + "/made"))
    if (entry.is_regular_file())
      files.insert(fs::relative(entry.path(), folder_ + "/made").string());
  EXPECT_EQ(files,
            (std::set<std::string>{
                "report.json", "run.csv", "sheet/frames.csv", "sheet/surface-0000-t0.166667s.ply",
                "sheet/surface-0001-t0.333333s.ply", "sheet/surface-0002-t0.500000s.ply"}));
  EXPECT_EQ(json::parse(std::ifstream(folder_ + "/made/report.json")), json::parse(result.out));
  const auto table = testing::all_lines(testing::slurp(folder_ + "/made/run.csv"));
  ASSERT_EQ(table.size(), 1U + 4U);
  EXPECT_EQ(table[0],
            "t,kinetic,elastic,gravity,total,damped,wind,pins,contact,numerical,px,py,pz,lx,ly,lz,"
            "penetration");
}

TEST_F(ClothProgram, WritesWhatOtherProgramsOpen) {
  std::ofstream(folder_ + "/scene.toml") << small_sheet("name = \"sheet\"\n");
  const ProgramResult result = run_program(
      folder_, kTremolo +
                   "export scene.toml --rate 30 --pc2 a.pc2 --mdd b.mdd --pvd c.pvd --usda d.usda "
                   "--series e.obj --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["frames"], 16);
  // A head of 32 bytes, then 36 positions of 16 frames.
  EXPECT_EQ(fs::file_size(folder_ + "/a.pc2"), 32U + 16U * 36U * 12U);
  EXPECT_EQ(fs::file_size(folder_ + "/b.mdd"), 8U + 16U * 4U + 16U * 36U * 12U);
  EXPECT_TRUE(fs::exists(folder_ + "/c.pvd"));
  EXPECT_TRUE(fs::exists(folder_ + "/d.usda"));
  EXPECT_TRUE(fs::exists(folder_ + "/e-0015.obj"));
}

// Exports use modes computed from the recording.
TEST_F(ClothProgram, WritesPagesAndGlbToAThousandthOfItsSize) {
  std::ofstream(folder_ + "/scene.toml") << small_sheet("name = \"sheet\"\n");
  const ProgramResult result = run_program(
      folder_, kTremolo + "export scene.toml --rate 30 --page a.html --glb b.glb --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json files = json::parse(result.out)["files"];
  ASSERT_EQ(files.size(), 2U);
  for (const json& file : files) {
    EXPECT_LE(file["recorded_modes_error"].get<double>(), 1e-3) << file;
    EXPECT_LE(file["position_error"].get<double>(), 1e-4) << file;
    EXPECT_GT(file["recorded_modes"].get<int>(), 2) << file;
    EXPECT_LE(file["recorded_modes"].get<int>(), 16) << file;  // of 16 frames
  }
  const ProgramResult live =
      run_program(folder_, kTremolo + "export scene.toml --page a.html --live x.tremolo");
  EXPECT_EQ(live.code, 2) << live.err;
}

// The second scene's positions are those of the first, and so far to the right as it is broad and a
// quarter.
TEST_F(ClothProgram, ASecondSceneIsWrittenBesideTheFirst) {
  std::ofstream(folder_ + "/scene.toml") << small_sheet("name = \"sheet\"\n");
  std::ofstream(folder_ + "/other.toml") << small_sheet("name = \"sheet\"\n");
  const auto exported = [&](const std::string& flags) {
    return run_program(folder_, kTremolo + "export scene.toml --rate 30 " + flags);
  };
  const ProgramResult result = exported("--beside other.toml --pc2 a.pc2 --page a.html --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["bodies"], 2);
  const std::string first = testing::slurp(folder_ + "/a-sheet.pc2"),
                    second = testing::slurp(folder_ + "/a-sheet-2.pc2");
  ASSERT_EQ(first.size(), 32U + 16U * 36U * 12U);
  ASSERT_EQ(first.size(), second.size());
  float low = 1e9F, high = -1e9F;
  for (std::size_t at = 32; at < 32 + 36 * 12; at += 12) {
    float a[3], b[3];
    std::memcpy(a, first.data() + at, 12);
    std::memcpy(b, second.data() + at, 12);
    EXPECT_EQ(a[1], b[1]);
    EXPECT_EQ(a[2], b[2]);
    low = std::min(low, a[0]);
    high = std::max(high, a[0]);
    EXPECT_NEAR(b[0] - a[0], 1.25, 1e-6);
  }
  EXPECT_NEAR(high - low, 1.0, 1e-6);
  EXPECT_EQ(exported("--beside other.toml --step 0 --pc2 a.pc2").code, 3);
  EXPECT_EQ(exported("--beside gone.toml --pc2 a.pc2").code, 1);
}

TEST_F(ClothProgram, OtherCommandsSayWhatGoesInstead) {
  expect_refused(small_sheet(), "--load applies only to bodies", "--load square");
  expect_refused(small_sheet(), "cloth has no method", "--integrator ep4");
  expect_refused(small_sheet(), "half a step", "--step 0.01 --duration 0.004");
}

TEST_F(ClothProgram, FlagsOfBodiesAreRefusedByTheirName) {
  const std::string flags =
      "--load none\n--frequency 2\n--sweep 1,2\n--load-duration 1\n--signal a.csv\n--at 1\n"
      "--force 0,0,1\n--scale 2\n--deflect 5%\n--start static\n--wav a.wav\n--listen 1\n"
      "--modes 2\n--linear\n--hull\n--rescale young=1e6\n--alpha 1\n--beta 1\n"
      "--damping-ratio 1:0.1,9:0.1\n--newmark-beta 0.3\n--newmark-gamma 0.6\n--split thesis\n"
      "--safety 0.5\n--coordinate all\n--velocities\n--probe 1\n--save a\n--restore a\n"
      "--threads 2\n--degree linear\n";
  for (const std::string& flag : testing::all_lines(flags)) {
    const ProgramResult result = run(small_sheet(), flag);
    EXPECT_EQ(result.code, 2) << flag << "\n" << result.err;
    const std::string words = flag.substr(0, flag.find(' ')) + " applies only to bodies";
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err << "\ninstead of " << words;
  }
}

TEST_F(ClothProgram, ExplicitMethodsAreRefusedBeyondTheirLimitWhichIsTold) {
  for (const char* method :
       {"explicit-euler", "symplectic-euler", "explicit-midpoint", "rk4", "implicit-euler-sweep"}) {
    const ProgramResult result = run(small_sheet(), std::string("--integrator ") + method);
    EXPECT_NE(result.code, 0) << method;
    EXPECT_NE(result.err.find("the limit is"), std::string::npos) << method << result.err;
  }
  const ProgramResult fine =
      run(small_sheet(), "--integrator symplectic-euler --step 0.0001 --json");
  ASSERT_EQ(fine.code, 0) << fine.err;
  EXPECT_GT(json::parse(fine.out)["stability_limit_s"].get<double>(), 1e-4);
}

TEST_F(ClothProgram, BadInputIsNamed) {
  const std::string head = "[[cloths]]\ncolumns = 4\nrows = 4\n";
  expect_refused({
      {head + "colour = 1\n", "cloth 1: unknown key 'colour'"},
      {head + "alpha = 1\n", "cloth 1: a cloth's springs have their own dampers"},
      {head + "load = \"sine\"\n", "cloth 1: loads act on a cloth that is one of [[bodies]]"},
      {"[[cloths]]\ncolumns = 4\n", "`columns` and `rows`, or a `file`"},
      {"[[cloths]]\ncolumns = 1\nrows = 4\n", "'columns' must be from 2"},
      {head + "structural = [-1, 0]\n", "structural"},
      {head + "density = 0\n", "density"},
      {head + "width = 0\n", "width"},
      {head + "pins = \"middle\"\n", "'middle' is no place of particles"},
      {head + "pins = 16\n", "there is no particle 16"},
      {head + "pins = \"near:1,2\"\n", "near:X,Y,Z"},
      {head + "[[cloths.pins]]\nuntil = 2\n", "it has no `at`"},
      {head + "file = \"a.obj\"\n", "leave it or `file` out"},
      {"[[cloths]]\nfile = \"none.obj\"\n", "none.obj"},
      {head + "[[balls]]\nmass = 0\n", "mass"},
      {head + "[[balls]]\nfixed = true\nmass = 2\n", "applies only to a ball that is not fixed"},
      {head + "[[balls]]\nposition = [0.3, 0.3, 0]\nradius = 0.2\n", "ball-1"},
      {head + "[[balls]]\nposition = [0.5, 0.5, 0.02]\nradius = 0.1\n",
       "begins 0.08 m inside ball 'ball-1'"},
      {head + "[[colliders]]\nname = \"s\"\nshape = \"sphere\"\nposition = [0.9, 0.9, 0]\n"
              "radius = 0.1\n",
       "inside collider 's'"},
      {head + "[[hands]]\nfrom = 1\n", "hand 1: it has no `at`"},
      {head + "[[hands]]\nat = 16\n", "there is no particle 16"},
      {head + "[[hands]]\nat = \"top\"\n", "'top' is 4 particles, a hand holds one"},
      {head + "[[hands]]\nat = 1\ncloth = \"silk\"\n", "there is no cloth 'silk'"},
      {head + "[[hands]]\nat = 1\nfrom = 2\nuntil = 1\n", "until must be later than from"},
      {head + "[[hands]]\nat = 1\nstiffness = 3\n", "hand 1: unknown key 'stiffness'"},
      {"gust = 0.4\n" + head, "it varies the `wind`"},
      {"integrator = \"ep4\"\n" + head, "ep4"},
      {head + "name = \"low\"\n" + head + "name = \"high\"\n", "`cloths-pass = true` allows"},
      {"self-contact = true\n" + head, "unknown key 'self-contact'"},
      {head + "[[bodies]]\nname = \"horse\"\n", "do not go together"},
  });
}

TEST_F(ClothProgram, SeveralClothsPassWhereTheSceneSaysThatTheyMay) {
  const std::string grid = "[[cloths]]\ncolumns = 4\nrows = 4\n";
  const ProgramResult result = run(
      "cloths-pass = true\n" + grid + "name = \"low\"\n" + grid + "name = \"high\"\n", "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["cloths"].size(), 2U);
}

TEST_F(ClothProgram, BadMeshesAreNamed) {
  const auto mesh = [&](const std::string& text) {
    std::ofstream(folder_ + "/mesh.obj") << text;
    return run("[[cloths]]\nfile = \"mesh.obj\"\n");
  };
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  EXPECT_EQ(mesh(square + "f 1 2 3\nf 1 3 4\n").code, 0);
  EXPECT_EQ(mesh(square + "v 5 5 5\nf 1 2 3\nf 1 3 4\n").code, 3);  // a vertex by itself
  EXPECT_EQ(mesh(square + "v 0 0 0\nf 1 5 3\nf 1 3 4\n").code, 3);  // no length between two
  std::string fan = "v 0 0 0\nv 1 0 0\n";
  for (int k = 0; k < 1000; ++k)
    fan += "v 0.5 " + std::to_string(std::cos(0.006 * k)) + " " +
           std::to_string(std::sin(0.006 * k)) + "\nf 1 2 " + std::to_string(k + 3) + "\n";
  EXPECT_EQ(mesh(fan).code, 3);
}

TEST_F(ClothProgram, InspectTellsWhatASceneHoldsAndWhichStepsItStands) {
  std::ofstream(folder_ + "/scene.toml")
      << "integrator = \"rk4\"\n" + small_sheet("structural = [400, 0]\n");  // beyond its limit
  const ProgramResult result = run_program(folder_, kTremolo + "inspect scene.toml --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json contents = json::parse(result.out);
  const json& cloth = contents["cloths"][0];
  EXPECT_EQ(cloth["particles"], 36);
  EXPECT_EQ(cloth["held"], 2);
  EXPECT_EQ(cloth["triangles"], 50);
  EXPECT_EQ(cloth["structural"], 60);
  EXPECT_EQ(cloth["shear"], 50);
  EXPECT_EQ(cloth["bend"], 48);
  // 0.2 kg/m^2 of a square metre.
  EXPECT_NEAR(cloth["mass_kg"].get<double>(), 0.2, 1e-12);
  const json& limits = contents["stability_limits_s"];
  EXPECT_FALSE(limits.contains("implicit-euler"));
  EXPECT_LT(limits["rk4"].get<double>(), contents["step"].get<double>());
  // The limit is that which a run is refused with.
  const ProgramResult refused = run_program(folder_, kTremolo + "run scene.toml");
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_EQ(run_program(folder_, kTremolo + "inspect scene.toml --select x").code, 2);
}

// Of colliders and of fixed balls; keyframes that begin at the identity, and poses in the world,
// are no reason for it.
TEST_F(ClothProgram, KeyframesAwayFromThePositionAreWarnedOf) {
  const auto moved = [](const std::string& keys) {
    return small_sheet() +
           "[[balls]]\nname = \"b\"\nposition = [0, 0, -3]\nfixed = true\nmotion = { kind = "
           "\"keyframes\", " +
           keys +
           " }\n[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nposition = [0, 0, "
           "-3]\nmotion = { kind = \"keyframes\", " +
           keys + " }\n";
  };
  const std::string away = moved("keys = [[0, 0, 0, -3], [1, 0, 0, -4]]");
  ProgramResult result = run(away, "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* whose : {"ball 'b'", "collider 'floor'"})
    EXPECT_NE(result.err.find(std::string(whose) + ": its keyframes put it 3 m and 0 degrees"),
              std::string::npos)
        << result.err;
  EXPECT_EQ(json::parse(result.out)["warnings"].size(), 2u);
  result = run_program(folder_, kTremolo + "inspect scene.toml --json");
  EXPECT_NE(result.err.find("frame = \"world\""), std::string::npos) << result.err;
  EXPECT_EQ(json::parse(result.out)["warnings"].size(), 2u);
  for (const char* fine : {"keys = [[0, 0, 0, 0], [1, 0, 0, -1]]",
                           "frame = \"world\", keys = [[0, 0, 0, -3], [1, 0, 0, -4]]"}) {
    result = run(moved(fine), "--json");
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(json::parse(result.out)["warnings"].empty()) << result.out;
  }
}

// 60 s of each scene at 1/60 s under each method without a limit, in the long form; else a second
// under the quickest.
#ifdef TREMOLO_LONG_TESTS
constexpr const char* kLastingMethods[] = {
    "implicit-euler", "implicit-euler-linear", "midpoint", "newmark", "bdf2", "energy"};
#else
constexpr const char* kLastingMethods[] = {"implicit-euler-linear"};
#endif

class ClothScenes : public ClothProgram,
                    public ::testing::WithParamInterface<std::tuple<const char*, const char*>> {};

TEST_P(ClothScenes, ReachTheirEndWithNoParticleInAnything) {
  const auto [scene, method] = GetParam();
#ifdef TREMOLO_LONG_TESTS
  const std::string duration = "60";
#else
  const std::string duration = "1";
#endif
  const ProgramResult result =
      run_program(folder_, kTremolo + "run " + asset(scene) + " --json --integrator " + method +
                               " --duration " + duration);
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_NEAR(report["reached"].get<double>(), std::stod(duration), 1e-6);
  EXPECT_TRUE(report["energy_final"].is_number());
  // Rounding of a distance of a metre.
  EXPECT_LE(report["penetration_max"].get<double>(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, ClothScenes,
                         ::testing::Combine(::testing::Values("cloth-hanging", "cloth-sphere",
                                                              "cloth-spheres", "cloth-flag",
                                                              "cloth-trampoline", "cloth-curtain"),
                                            ::testing::ValuesIn(kLastingMethods)),
                         [](const auto& instance) {
                           std::string name = std::string(std::get<0>(instance.param)) + "_" +
                                              std::string(std::get<1>(instance.param));
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

}  // namespace
}  // namespace tremolo
