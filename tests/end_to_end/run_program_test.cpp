// tremolo inspect, run and plot as a user meets them, on a small clamped block.
#include "tests/support/run_program.h"

#include <filesystem>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/box_mesh.h"
#include "tests/support/mesh_file.h"

namespace tremolo {
namespace {

using nlohmann::json;
using testing::box_mesh;
using testing::fresh_folder;
using testing::ProgramResult;
using testing::run_program;
using testing::slurp;

const std::string kProgram = TREMOLO_BIN_DIR "/tremolo ";

class RunProgram : public ::testing::Test {
 protected:
  // One model for all tests: a soft bar, 0.4 m, loaded at its free end.
  static void SetUpTestSuite() {
    model_folder_ = testing::fresh_folder();
    testing::write_veg(model_folder_ + "/bar.veg", box_mesh({8, 2, 2}, {0.4, 0.05, 0.06}));
    const ProgramResult made = run_program(
        model_folder_, TREMOLO_BIN_DIR
        "/tremolo-precompute bar.veg -o bar.tremolo --young 2e6 --density 1000 --fix 'x<0.001' "
        "--load-at 'x>0.399' --load-force 0,0,-1 --linear-modes 6 --modes 12");
    ASSERT_EQ(made.code, 0) << made.err;
  }

  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kProgram + arguments);
  }
  static std::string model() { return model_folder_ + "/bar.tremolo"; }

  void expect_failure(const ProgramResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }

  static inline std::string model_folder_;
  std::string folder_;
};

TEST_F(RunProgram, InspectTellsWhatScriptsRelyOn) {
  const ProgramResult result = run("inspect " + model() + " --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["format_version"], "1.0");
  EXPECT_EQ(report["n"], 81);
  EXPECT_EQ(report["m"], 192);
  EXPECT_EQ(report["r"], 12);
  EXPECT_EQ(report["frequencies_hz"].size(), 12);
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
  const double highest = report["frequencies_hz"].back();
  EXPECT_NEAR(report["explicit_step_limit_s"], 1 / (3.141592653589793 * highest), 1e-12);
  EXPECT_EQ(report["provenance"]["material"]["young_pa"], 2e6);
  EXPECT_GE(report["sections"].size(), 10);
  EXPECT_EQ(run("inspect " + model()).code, 0);
}

TEST_F(RunProgram, RunTellsWhatScriptsRelyOnForEveryMethod) {
  for (const char* name : {"verlet", "midpoint", "newmark", "imexv", "imexv-thesis"}) {
    const ProgramResult result = run("run " + model() + " --json --step 0.0001 --duration 0.1 " +
                                     "--scale 0.5 --integrator " + name);
    ASSERT_EQ(result.code, 0) << name << result.err;
    const json report = json::parse(result.out);
    EXPECT_EQ(report["integrator"], name);
    EXPECT_EQ(report["step"], 0.0001);
    EXPECT_EQ(report["duration"], 0.1);
    EXPECT_EQ(report["steps"], 1000);
    EXPECT_NEAR(report["reached"], 0.1, 1e-12);
    for (const char* key : {"iterations_per_step", "microseconds_per_step", "energy_initial",
                            "energy_final", "energy_drift_max"})
      EXPECT_TRUE(report[key].is_number()) << key;
    const bool splits = std::string(name).starts_with("imexv");
    EXPECT_EQ(report["low_modes"].is_number(), splits);
    if (splits) {
      EXPECT_EQ(report["low_modes"].get<int>() + report["high_modes"].get<int>(), 12);
    }
    EXPECT_GT(report["energy_final"], 0);
  }
}

TEST_F(RunProgram, MethodsAgreeOnAResolvedMotion) {
  double energies[2];
  int i = 0;
  for (const char* name : {"verlet", "midpoint"}) {
    const ProgramResult result =
        run("run " + model() + " --json --step 0.0001 --duration 0.5 " + "--integrator " + name);
    ASSERT_EQ(result.code, 0) << result.err;
    energies[i++] = json::parse(result.out)["energy_final"];
  }
  EXPECT_NEAR(energies[0], energies[1], 1e-3 * energies[0]);  // (h omega)^2 of the motion's modes
}

TEST_F(RunProgram, ALinearModelTakesTheSameWayAtEveryStepByDefault) {
  // 24 ms and 0.1 ms: hw of the highest coordinate is far above 2 at the one and resolved at the
  // other.
  std::vector<double> ends;
  for (const char* step : {"0.024", "0.0001"}) {
    const ProgramResult result = run("run " + model() + " --linear --json --duration 0.48 " +
                                     "--alpha 0.5 --beta 0.001 --load constant --step " + step);
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    EXPECT_EQ(report["integrator"], "ep4");
    EXPECT_EQ(report["iterations_per_step"], 0.0);
    EXPECT_LE(report["energy_drift_max"], 1e-12);
    EXPECT_GT(report["dissipated"], 0.0);
    ends.push_back(report["energy_final"]);
    ends.push_back(report["dissipated"]);
  }
  EXPECT_NEAR(ends[0] / ends[2], 1.0, 1e-11);
  EXPECT_NEAR(ends[1] / ends[3], 1.0, 1e-11);
}

TEST_F(RunProgram, WritesARowForEachRecordedMomentWithTheChosenColumns) {
  const ProgramResult result =
      run("run " + model() +
          " --duration 0.3 --every 10 --probe 80 --coordinate 0 --coordinate 3 "
          "--out result --surfaces 2 --surface-format obj");
  ASSERT_EQ(result.code, 0) << result.err;
  std::ifstream csv(folder_ + "/result/run.csv");
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "t,kinetic,potential,total,high_band,work,dissipated,q0,q3,u80x,u80y,u80z");
  int rows = 0;
  while (std::getline(csv, line)) {
    ++rows;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 11);
  }
  EXPECT_EQ(rows, 11);  // 100 steps and the start
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/result/surface-0001.obj"));
  EXPECT_TRUE(json::parse(slurp(folder_ + "/result/report.json")).contains("energy_drift_max"));
}

TEST_F(RunProgram, AnotherRunIntoTheSameFolderLeavesNothingOfTheFirst) {
  const auto names = [&] {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/result"))
      found.insert(entry.path().filename().string());
    return found;
  };
  ASSERT_EQ(run("run " + model() + " --duration 0.1 --out result --surfaces 3").code, 0);
  std::ofstream(folder_ + "/result/energy.svg") << "of the first run";
  std::ofstream(folder_ + "/result/surface-mine.ply") << "kept";
  std::ofstream(folder_ + "/result/notes.txt") << "kept";
  const std::string second = "run " + model() + " --duration 0.1 --out result --surfaces 1";
  ASSERT_EQ(run(second + " --surface-format obj").code, 0);
  EXPECT_EQ(names(), (std::set<std::string>{"run.csv", "report.json", "surface-0000.obj",
                                            "surface-mine.ply", "notes.txt"}));
  // A run that is refused takes nothing away.
  EXPECT_EQ(run(second + " --load thunder").code, 2);
  EXPECT_TRUE(names().contains("surface-0000.obj"));
}

TEST_F(RunProgram, DrawsTheEnergyOfSeveralRuns) {
  ASSERT_EQ(run("run " + model() + " --duration 0.5 --out a --plot").code, 0);
  ASSERT_EQ(run("run " + model() + " --duration 0.5 --out b --integrator newmark").code, 0);
  EXPECT_NE(slurp(folder_ + "/a/energy.svg").find("</svg>"), std::string::npos);
  const ProgramResult result = run("plot a b -o both.svg");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(slurp(folder_ + "/both.svg").find("total energy"), std::string::npos);
  expect_failure(run("plot a nowhere -o both.svg"), 1, "nowhere");
  expect_failure(run("plot a -o both.bmp"), 2, ".svg or .png");
  std::ofstream(folder_ + "/other.csv") << "time,total\n0,0\n";
  expect_failure(run("plot a other.csv -o other.svg"), 3, "column `t`");
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/other.svg"));
}

TEST_F(RunProgram, AnOrbitThatLeavesItsEnergyBoundIsReported) {
  // Ten times the explicit limit.
  const ProgramResult result =
      run("run " + model() + " --json --integrator verlet --step 0.02 --duration 5");
  expect_failure(result, 5, "times all that the load put in");
  const json report = json::parse(result.out);
  EXPECT_EQ(report["exit_code"], 5);
  EXPECT_LT(report["reached"], 5);
}

TEST_F(RunProgram, ASolverThatGivesUpIsReported) {
  const ProgramResult result =
      run("run " + model() + " --json --integrator midpoint --scale 500 --max-iterations 1");
  expect_failure(result, 4, "did not converge");
  const json report = json::parse(result.out);
  EXPECT_EQ(report["exit_code"], 4);
  EXPECT_FALSE(report["reason"].is_null());
}

TEST_F(RunProgram, WrongUsageAndBadFilesAreToldApart) {
  expect_failure(run("run " + model() + " --integrator leapfrog"), 2, "imexv");  // lists the names
  expect_failure(run("run " + model() + " --step -1"), 3, "--step");
  expect_failure(run("run " + model() + " --duration 0"), 3, "--duration");
  expect_failure(run("run " + model() + " --no-such-flag"), 2, "no-such-flag");
  expect_failure(run("run " + model() + " --load hammer"), 2, "impulse");
  expect_failure(run("run " + model() + " --at 80 --force 1,2"), 2, "X,Y,Z");
  expect_failure(run("run " + model() + " --at 80"), 2, "--force");
  expect_failure(run("run " + model() + " --at 8000 --force 1,2,3"), 3, "8000");
  expect_failure(run("run " + model() + " --modes 13"), 3, "13");
  expect_failure(run("run " + model() + " --probe 8000"), 3, "8000");
  expect_failure(run("run " + model() + " --alpha=-1"), 3, "");
  expect_failure(run("run " + model() + " --at 0 --force 0,0,1"), 3, "no vertex there moves");
  EXPECT_EQ(run("inspect " + model() + " --json > /dev/full; exit $?;").code, 1);
  expect_failure(run("run nowhere.tremolo"), 1, "nowhere.tremolo");
  std::ofstream(folder_ + "/bad.tremolo") << slurp(model()).substr(0, 5000);
  expect_failure(run("run bad.tremolo"), 3, "truncated");
  expect_failure(run("inspect bad.tremolo"), 3, "truncated");
  std::string damaged = slurp(model());
  damaged[damaged.size() / 2] ^= 1;
  std::ofstream(folder_ + "/bad.tremolo") << damaged;
  expect_failure(run("inspect bad.tremolo"), 3, "checksum");
  expect_failure(run("run " + model() + " --duration 0.1 --out /dev/null/x"), 1, "/dev/null/x");
  expect_failure(run(""), 2, "");
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_EQ(run("run --help").code, 0);
  EXPECT_EQ(run("--version").code, 0);
}

TEST_F(RunProgram, ASceneGivesTheDefaultsAndFlagsWin) {
  std::ofstream(folder_ + "/scene.toml") << "[first]\nmodel = \"" << model()
                                         << "\"\nintegrator = \"newmark\"\nduration = 0.3\n"
                                            "load = \"impulse\"\nprobe = [80]\n"
                                            "[second]\nmodel = \""
                                         << model() << "\"\nduration = 0.6\n";
  const ProgramResult result = run("run scene.toml --json --duration 0.15 --out both");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  ASSERT_EQ(report["bodies"].size(), 2);
  EXPECT_EQ(report["bodies"][0]["integrator"], "newmark");
  EXPECT_EQ(report["bodies"][1]["integrator"], "ep4");
  EXPECT_EQ(report["bodies"][1]["duration"], 0.15);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/both/second/run.csv"));
}

TEST_F(RunProgram, AWrongSceneNamesItsLine) {
  const auto expect = [&](const std::string& text, const std::string& words) {
    std::ofstream(folder_ + "/scene.toml") << text;
    expect_failure(run("run scene.toml"), 3, words);
  };
  expect("[a]\nmodel = \"" + model() + "\"\nspeed = 3\n", "line 3: unknown key 'speed'");
  expect("[a]\nmodel = \"" + model() + "\"\nstep = \"fast\"\n", "line 3");
  expect("[a\n", "line 1");
  expect("step = 1\n", "outside a table");
  expect("[a]\nstep = 1\n", "names no model");
  expect("", "empty");
  expect("# nothing\n", "no body");
  expect("[\"a/../../b\"]\nmodel = \"x\"\n", "letters");  // it would become a folder's name
  expect_failure(run("run nowhere.toml"), 1, "nowhere.toml");
}

}  // namespace
}  // namespace tremolo
