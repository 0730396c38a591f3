// tremolo inspect, run and plot as a user meets them, on a small clamped block.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;

class RunProgram : public ::testing::Test {
 protected:
  // One model for all tests: a soft bar, 0.4 m, loaded at its free end.
  static void SetUpTestSuite() {
    model_folder_ = testing::fresh_folder();
    testing::write_veg(model_folder_ + "/bar.veg", box_mesh({8, 2, 2}, {0.4, 0.05, 0.06}));
    const ProgramResult made = run_program(
        model_folder_, TREMOLO_BIN_DIR
        "/tremolo-precompute bar.veg -o bar.tremolo --young 2e6 --density 1000 --fix 'x<0.001' "
        "--load-at 'x>0.399' --load-force 0,0,-1 --linear-modes 6 --modes 12 --order 1");
    ASSERT_EQ(made.code, 0) << made.err;
  }

  void SetUp() override {
    // A shell that starts the tests in the background ignores the signal; the programs would
    // inherit that.
    std::signal(SIGINT, SIG_DFL);
    folder_ = fresh_folder();
  }

  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kTremolo + arguments);
  }
  static std::string model() { return model_folder_ + "/bar.tremolo"; }

  void expect_failure(const ProgramResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
  // The report of a run of the model that ends with this exit code and these words.
  json failed_run(const std::string& flags, int code, const std::string& words) {
    const ProgramResult result = run("run " + model() + " --json " + flags);
    expect_failure(result, code, words);
    const json report = json::parse(result.out, nullptr, false);
    EXPECT_EQ(report["exit_code"], code);
    EXPECT_EQ(report["schema"], 1);
    return report;
  }

  static inline std::string model_folder_;
  std::string folder_;
};

TEST_F(RunProgram, InspectTellsWhatScriptsRelyOn) {
  const ProgramResult result = run("inspect " + model() + " --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["format_version"], "1.4");
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

// The warning names the longest step that draws none.
TEST_F(RunProgram, AStepTooLongForTheFirstModeIsWarnedOf) {
  const ProgramResult inspected = run("inspect " + model() + " --json");
  ASSERT_EQ(inspected.code, 0) << inspected.err;
  const json contents = json::parse(inspected.out);
  const double first = contents["frequencies_hz"][0];
  EXPECT_NEAR(contents["resolving_step_s"], 1.0 / (20.0 * first), 1e-12);
  EXPECT_EQ(contents["warnings"].empty(), 0.003 * 20.0 * first <= 1.0);
  const std::string command = "run " + model() + " --json --duration 0.5 --step ";
  const ProgramResult coarse = run(command + std::to_string(2.0 / (20.0 * first)));
  ASSERT_EQ(coarse.code, 0) << coarse.err;
  EXPECT_NE(coarse.err.find("  warning: the first mode"), std::string::npos) << coarse.err;
  const json warnings = json::parse(coarse.out)["warnings"];
  ASSERT_EQ(warnings.size(), 1U);
  const std::string text = warnings[0];
  const std::size_t named = text.find("--step ");
  ASSERT_NE(named, std::string::npos) << text;
  std::istringstream words(text.substr(named + 7));
  std::string step;
  words >> step;
  const ProgramResult fine = run(command + step);
  ASSERT_EQ(fine.code, 0) << fine.err;
  EXPECT_EQ(json::parse(fine.out)["warnings"].size(), 0U) << fine.err;
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
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/result/surface-0001-t0.300000s.obj"));
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
  std::ofstream(folder_ + "/result/energy.html") << "of the first run";
  std::ofstream(folder_ + "/result/surface-mine.ply") << "kept";
  std::ofstream(folder_ + "/result/notes.txt") << "kept";
  const std::string second = "run " + model() + " --duration 0.1 --out result --surfaces 1";
  ASSERT_EQ(run(second + " --surface-format obj").code, 0);
  EXPECT_EQ(names(), (std::set<std::string>{"run.csv", "report.json", "frames.csv",
                                            "surface-0000-t0.099000s.obj", "surface-mine.ply",
                                            "notes.txt"}));
  // A run that is refused takes nothing away.
  EXPECT_EQ(run(second + " --load thunder").code, 2);
  EXPECT_TRUE(names().contains("surface-0000-t0.099000s.obj"));
}

TEST_F(RunProgram, ADegreeOfAReducedBodyIsRefused) {
  expect_failure(run("run " + model() + " --duration 0.1 --degree linear"), 2, "kind \"tets\"");
}

TEST_F(RunProgram, DrawsTheEnergyOfSeveralRuns) {
  ASSERT_EQ(run("run " + model() + " --duration 0.5 --out a --plot").code, 0);
  ASSERT_EQ(run("run " + model() + " --duration 0.5 --out b --integrator newmark").code, 0);
  EXPECT_NE(slurp(folder_ + "/a/energy.html").find("\"label\":\"ep4\""), std::string::npos);
  ASSERT_EQ(run("plot a b -o both.html").code, 0);
  const std::string page = slurp(folder_ + "/both.html");
  EXPECT_NE(page.find("\"label\":\"a\""), std::string::npos);
  EXPECT_NE(page.find("\"label\":\"b\""), std::string::npos);
  EXPECT_NE(page.find("total energy"), std::string::npos);
  expect_failure(run("plot a nowhere -o both.html"), 1, "nowhere");
  expect_failure(run("plot a -o both.svg"), 2, "a page, .html");
  std::ofstream(folder_ + "/other.csv") << "time,total\n0,0\n";
  expect_failure(run("plot a other.csv -o other.html"), 3, "column `t`");
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/other.html"));
}

TEST_F(RunProgram, AnOrbitThatLeavesItsEnergyBoundIsReported) {
  // Ten times the explicit limit.
  const json report = failed_run("--integrator verlet --step 0.02 --duration 5", 5,
                                 "times all that was put in");
  EXPECT_LT(report["reached"], 5);
}

TEST_F(RunProgram, ASolverThatGivesUpIsReported) {
  const json report =
      failed_run("--integrator midpoint --scale 500 --max-iterations 1", 4, "did not converge");
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

// A scene and a flag that state one thing in two different forms: the flag is used.
TEST_F(RunProgram, OfTwoWaysToSayOneThingTheFlagsWins) {
  std::ofstream(folder_ + "/course.csv") << "0,1\n0.3,1\n";
  const auto report = [&](const std::string& key, const std::string& flags) {
    std::ofstream(folder_ + "/scene.toml") << "[b]\nmodel = \"" << model() << "\"\n" << key << "\n";
    const ProgramResult result = run("run scene.toml --duration 0.3 --json " + flags);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? json::parse(result.out) : json();
  };
  const json course = report("signal = \"course.csv\"", "--load impulse");
  EXPECT_EQ(course["load"], "impulse");
  EXPECT_EQ(course["energy_final"], report("", "--load impulse")["energy_final"]);
  const json scaled = report("deflect = \"5%\"", "--scale 2");
  EXPECT_EQ(scaled["scale"], 2.0);
  EXPECT_TRUE(scaled["deflect"].is_null());
  const json deflected = report("scale = 3.0", "--deflect 5%");
  EXPECT_NEAR(deflected["largest_displacement_share"], 0.05, 0.0005);
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
  expect("[a]\nstep = 1\n", "has no key 'model'");
  expect("", "empty");
  expect("# nothing\n", "no body");
  expect("[\"a/../../b\"]\nmodel = \"x\"\n", "letters");  // it would become a folder's name
  expect_failure(run("run nowhere.toml"), 1, "nowhere.toml");
}

// The numbers of a CSV, a row a line, and the position of each column.
struct Csv {
  std::map<std::string, std::size_t> columns;
  std::vector<std::vector<double>> rows;
  double at(std::size_t row, const std::string& name) const { return rows[row][columns.at(name)]; }
};

Csv read_csv(const std::string& path) {
  Csv csv;
  std::istringstream lines(slurp(path));
  std::string line, cell;
  std::getline(lines, line);
  for (std::istringstream names(line); std::getline(names, cell, ',');)
    csv.columns.emplace(cell, csv.columns.size());
  while (std::getline(lines, line)) {
    csv.rows.emplace_back();
    for (std::istringstream cells(line); std::getline(cells, cell, ',');)
      csv.rows.back().push_back(std::stod(cell));
    EXPECT_EQ(csv.rows.back().size(), csv.columns.size()) << line;
  }
  return csv;
}

// The table of a run of `model` in `folder`.
Csv recorded(const std::string& folder, const std::string& model, const std::string& options) {
  const ProgramResult result =
      run_program(folder, kTremolo + "run " + model + " " + options + " --out o");
  EXPECT_EQ(result.code, 0) << result.err;
  return read_csv(folder + "/o/run.csv");
}

TEST_F(RunProgram, TellsHowFarTheBodyMoved) {
  const ProgramResult result =
      run("run " + model() + " --duration 0.6 --step 0.001 --probe 'x>0.399' --out o --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_DOUBLE_EQ(report["size"], 0.4);
  // The vertex that moves most is at the free end, and it is recorded there.
  const Csv csv = read_csv(folder_ + "/o/run.csv");
  const std::string u = "u" + std::to_string(report["largest_displacement_vertex"].get<int>());
  double largest = 0;
  for (std::size_t row = 0; row < csv.rows.size(); ++row)
    largest = std::max(
        largest, std::hypot(csv.at(row, u + "x"), csv.at(row, u + "y"), csv.at(row, u + "z")));
  EXPECT_NEAR(report["largest_displacement"], largest, 0.01 * largest);  // every tenth step is seen
  EXPECT_NEAR(report["largest_displacement_share"], largest / 0.4, 0.01 * largest / 0.4);
  EXPECT_NE(result.err.find("% of its size"), std::string::npos) << result.err;
}

TEST_F(RunProgram, TheFirstAndTheLastMomentAreLookedAtToo) {
  // Five steps: fewer than lie between two looks.
  const ProgramResult few = run("run " + model() + " --load constant --duration 0.015 --json");
  ASSERT_EQ(few.code, 0) << few.err;
  EXPECT_NEAR(json::parse(few.out)["largest_displacement_at"], 0.015, 1e-12);
  // A released and damped body is never as far as at its start.
  const ProgramResult let_go =
      run("run " + model() + " --load none --start 80=0,0,-0.03 --alpha 20 --duration 0.3 --json");
  ASSERT_EQ(let_go.code, 0) << let_go.err;
  EXPECT_EQ(json::parse(let_go.out)["largest_displacement_at"], 0.0);
  EXPECT_GE(json::parse(let_go.out)["largest_displacement"], 0.0299);
}

TEST_F(RunProgram, DeflectScalesTheLoadUntilTheMotionIsSoLarge) {
  const ProgramResult result = run("run " + model() + " --duration 0.6 --deflect 5% --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_NEAR(report["largest_displacement_share"], 0.05, 0.0005);
  const double scale = report["scale"];
  EXPECT_NE(scale, 1.0);
  const ProgramResult same =
      run("run " + model() + " --duration 0.6 --json --scale " + report["scale"].dump());
  EXPECT_EQ(json::parse(same.out)["largest_displacement"], report["largest_displacement"]);
  expect_failure(run("run " + model() + " --deflect 5% --scale 2"), 2, "--scale");
  expect_failure(run("run " + model() + " --deflect 5% --load none"), 2, "none");
  expect_failure(run("run " + model() + " --deflect five"), 2, "5%");
  expect_failure(run("run " + model() + " --deflect 0"), 3, "positive");
  expect_failure(run("run " + model() + " --deflect 5% --at 80 --force 0,0,0"), 3, "zero");
}

TEST_F(RunProgram, AStaticStartStandsStillAsLongAsTheLoadLasts) {
  const Csv csv =
      recorded(folder_, model(), "--start static --load constant --duration 0.5 --coordinate all");
  const double potential = csv.at(0, "potential");
  EXPECT_GT(potential, 0);
  for (std::size_t row = 0; row < csv.rows.size(); ++row)
    EXPECT_LE(csv.at(row, "kinetic"), 1e-12 * potential) << row;
  expect_failure(run("run " + model() + " --start static --load sine"), 3, "no load acts");
}

TEST_F(RunProgram, AStartFromACsvGoesOnFromItsRow) {
  const std::string record = " --coordinate all --velocities --duration ";
  ASSERT_EQ(run("run " + model() + " --load impulse --out a" + record + "0.6").code, 0);
  ASSERT_EQ(
      run("run " + model() + " --load none --start a/run.csv@0.3 --out b" + record + "0.3").code,
      0);
  const Csv a = read_csv(folder_ + "/a/run.csv"), b = read_csv(folder_ + "/b/run.csv");
  ASSERT_EQ(a.rows.size(), 201u);
  for (std::size_t row = 0; row <= 100; ++row)
    EXPECT_NEAR(b.at(row, "q0"), a.at(100 + row, "q0"), 1e-8) << row;  // ten digits are written
  ASSERT_EQ(run("run " + model() + " --load none --start a/run.csv --out c" + record + "0.1").code,
            0);
  EXPECT_NEAR(read_csv(folder_ + "/c/run.csv").at(0, "p0"), a.at(200, "p0"), 1e-9);
  // A row without its end may be cut off in the middle of a number.
  std::ofstream(folder_ + "/cut.csv") << slurp(folder_ + "/a/run.csv") << "0.603,1,2";
  const ProgramResult cut =
      run("run " + model() + " --load none --start cut.csv --out e" + record + "0.1");
  ASSERT_EQ(cut.code, 0) << cut.err;
  EXPECT_NEAR(read_csv(folder_ + "/e/run.csv").at(0, "p0"), a.at(200, "p0"), 1e-9);
  ASSERT_EQ(run("run " + model() + " --out d --duration 0.1 --coordinate all").code, 0);
  expect_failure(run("run " + model() + " --start d/run.csv"), 3, "--velocities");
  expect_failure(run("run " + model() + " --start a/run.csv --modes 6"), 3, "more coordinates");
  expect_failure(run("run " + model() + " --start nowhere.csv"), 1, "nowhere.csv");
}

TEST_F(RunProgram, AStartFromADisplacementHasTheVertexThere) {
  ASSERT_EQ(run("run " + model() +
                " --load none --start 80=0,0.01,-0.03 --probe 80 --out o "
                "--duration 0.1")
                .code,
            0);
  const Csv csv = read_csv(folder_ + "/o/run.csv");
  EXPECT_NEAR(csv.at(0, "u80x"), 0, 1e-12);
  EXPECT_NEAR(csv.at(0, "u80y"), 0.01, 1e-9);
  EXPECT_NEAR(csv.at(0, "u80z"), -0.03, 1e-9);
  EXPECT_EQ(csv.at(0, "kinetic"), 0);
  EXPECT_GT(csv.at(10, "kinetic"), 0);
  // The mean of several vertices is there.
  ASSERT_EQ(run("run " + model() +
                " --load none --start 'x>0.399=0,0.004,-0.02' --probe 'x>0.399' --out m "
                "--duration 0.1")
                .code,
            0);
  const Csv several = read_csv(folder_ + "/m/run.csv");
  std::map<char, double> sum;
  for (const auto& [name, column] : several.columns)
    if (name.front() == 'u') sum[name.back()] += several.at(0, name);
  EXPECT_NEAR(sum['x'] / 9, 0, 1e-9);
  EXPECT_NEAR(sum['y'] / 9, 0.004, 1e-9);
  EXPECT_NEAR(sum['z'] / 9, -0.02, 1e-9);
  expect_failure(run("run " + model() + " --start 0=0,0,0.01"), 3, "cannot displace it");
  expect_failure(run("run " + model() + " --start 8000=0,0,0.01"), 3, "8000");
}

TEST_F(RunProgram, ProbesTakeSelectorsAndCoordinatesRanges) {
  const auto header = [&](const std::string& columns) {
    const ProgramResult result = run("run " + model() + " --duration 0.01 --out o " + columns);
    EXPECT_EQ(result.code, 0) << result.err;
    const std::string text = slurp(folder_ + "/o/run.csv");
    return text.substr(0, text.find('\n'))
        .substr(std::string("t,kinetic,potential,total,"
                            "high_band,work,dissipated")
                    .size());
  };
  EXPECT_EQ(header("--coordinate 2-4 --coordinate 0 --coordinate 3"), ",q2,q3,q4,q0");
  EXPECT_EQ(header("--coordinate all --modes 3 --velocities"), ",q0,q1,q2,p0,p1,p2");
  EXPECT_EQ(header("--probe 'x>0.399 and y>0.049 and z>0.059' --velocities"),
            ",u80x,u80y,u80z,v80x,v80y,v80z");
  EXPECT_EQ(header("--probe 80 --probe 'x>0.399 and y>0.049 and z>0.059'"), ",u80x,u80y,u80z");
  expect_failure(run("run " + model() + " --coordinate 5-2"), 2, "5-2");
  expect_failure(run("run " + model() + " --coordinate 10-12"), 3, "12");
  expect_failure(run("run " + model() + " --probe 'x>7'"), 3, "x>7");
  expect_failure(run("run " + model() + " --velocities"), 2, "--coordinate");
}

TEST_F(RunProgram, VelocitiesAreTheRatesOfDisplacements) {
  const Csv csv = recorded(folder_, model(),
                           "--step 0.0005 --duration 0.2 --load impulse --probe 80 --velocities");
  double error = 0, largest = 0;
  for (std::size_t row = 101; row + 1 < csv.rows.size(); ++row) {
    const double rate = (csv.at(row + 1, "u80z") - csv.at(row - 1, "u80z")) / 0.001;
    error = std::max(error, std::abs(csv.at(row, "v80z") - rate));
    largest = std::max(largest, std::abs(rate));
  }
  EXPECT_LE(error, 0.02 * largest);  // central differences, (h omega)^2 / 6 of its modes
}

TEST_F(RunProgram, ASignalFromAFileActsAsTheBuiltInOneOfTheSameShape) {
  std::ofstream(folder_ + "/square.csv") << "time,value\n0,1\n0.3,1\n";
  ASSERT_EQ(run("run " + model() + " --duration 0.6 --signal square.csv --out a").code, 0);
  ASSERT_EQ(run("run " + model() + " --duration 0.6 --load square --out b").code, 0);
  const Csv a = read_csv(folder_ + "/a/run.csv"), b = read_csv(folder_ + "/b/run.csv");
  ASSERT_EQ(a.rows.size(), 201u);
  for (std::size_t row = 0; row < a.rows.size(); ++row)  // averages are rounded differently
    EXPECT_NEAR(a.at(row, "total"), b.at(row, "total"), 1e-11 * b.at(200, "total")) << row;
  std::ofstream(folder_ + "/bad.csv") << "0,1\n1,2\n0.5,3\n";
  expect_failure(run("run " + model() + " --signal bad.csv"), 3, "moment 3");
  std::ofstream(folder_ + "/bad.csv") << "0,1\n1,high\n";
  expect_failure(run("run " + model() + " --signal bad.csv"), 3, "line 2");
  expect_failure(run("run " + model() + " --signal square.csv --load sine"), 2, "--load");
}

TEST_F(RunProgram, ARunThatIsInterruptedLeavesAGoodCsvAndSaysSo) {
  const std::string endless = kTremolo + "run " + model() + " --duration 1e6 --every 20 --out ";
  // A shell in the background ignores SIGINT: timeout sends it to a child that is not. In the
  // foreground it sends one signal; else two, the second of which may end the program at once.
  for (const std::string signal : {"INT", "TERM"}) {
    const std::string out = "o" + signal;
    const ProgramResult result =
        run_program(folder_, "timeout --foreground -k 60 --preserve-status -s " + signal + " 5 " +
                                 endless + out);
    const int number = signal == "INT" ? 2 : 15;
    EXPECT_EQ(result.code, 128 + number) << result.err;
    const json report = json::parse(slurp(folder_ + "/" + out + "/report.json"));
    EXPECT_EQ(report["exit_code"], 128 + number);
    EXPECT_NE(report["reason"].get<std::string>().find("signal"), std::string::npos);
    const std::string text = slurp(folder_ + "/" + out + "/run.csv");
    ASSERT_FALSE(text.empty());
    EXPECT_EQ(text.back(), '\n');
    const Csv csv = read_csv(folder_ + "/" + out + "/run.csv");
    ASSERT_GT(csv.rows.size(), 2u);
    EXPECT_LE(std::abs(csv.at(csv.rows.size() - 1, "t") - report["reached"].get<double>()), 0.06);
  }
}

// As a shell sees it, which then ends its script as well; and no further body is begun.
TEST_F(RunProgram, AnInterruptedSceneEndsByItsSignal) {
  std::ofstream(folder_ + "/two.toml")
      << "[first]\nmodel = \"" << model() << "\"\n[second]\nmodel = \"" << model() << "\"\n";
  const int status = std::system(
      ("cd '" + folder_ +
       "' && ulimit -t 60 && { (for wait in $(seq 600); do ls o/first/run.csv.partial-* && break; "
       "sleep 0.1; done >/dev/null 2>&1; sleep 0.3; kill -INT $$) & } && exec " +
       kTremolo + "run two.toml --duration 1e6 --every 1000 --out o >out.txt 2>err.txt")
          .c_str());
  ASSERT_TRUE(WIFSIGNALED(status)) << slurp(folder_ + "/err.txt");
  EXPECT_EQ(WTERMSIG(status), SIGINT) << slurp(folder_ + "/err.txt");
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/o/first/run.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/o/second"));
}

TEST_F(RunProgram, ALongRunTellsATerminalHowFarItIs) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(::grantpt(terminal), 0);
  ASSERT_EQ(::unlockpt(terminal), 0);
  const std::string end = ::ptsname(terminal);
  const int held = ::open(end.c_str(), O_RDWR | O_NOCTTY);  // else the output is lost
  ASSERT_GE(held, 0);
  const ProgramResult started =
      run_program(folder_, "(timeout -s KILL 300 " + kTremolo + "run " + model() +
                               " --duration 1e6 2>" + end + " >/dev/null & echo $!)");
  const int program = std::atoi(started.out.c_str());
  ASSERT_GT(program, 0) << started.err;
  // It waits for the words and not for a time, for slow machines.
  std::string said;
  for (int wait = 0; wait < 2400 && said.find(" left") == std::string::npos; ++wait) {
    char buffer[4000];
    const ::ssize_t length = ::read(terminal, buffer, sizeof(buffer));
    if (length > 0)
      said.append(buffer, static_cast<std::size_t>(length));
    else
      ::usleep(100000);
  }
  ::kill(program, SIGTERM);
  EXPECT_NE(said.find("bar: 0 %"), std::string::npos) << said;
  EXPECT_NE(said.find(" left"), std::string::npos) << said;
  ::close(held);
  ::close(terminal);
}

// So few of them that no full buffer is the reason.
TEST_F(RunProgram, TheRowsOfARunCanBeReadWhileItRuns) {
  const ProgramResult result = run_program(
      folder_, "(timeout -s KILL 300 " + kTremolo + "run " + model() +
                   " --duration 1e6 --every 20000 --out o & for wait in $(seq 2400); do "
                   "cat o/run.csv.partial-* > seen.csv; [ $(wc -l < seen.csv) -gt 1 ] && break; "
                   "sleep 0.1; done; kill $!; wait)");
  const std::string seen = slurp(folder_ + "/seen.csv");
  EXPECT_TRUE(seen.starts_with("t,kinetic,")) << result.err;
  EXPECT_EQ(seen.back(), '\n');
  EXPECT_GT(std::count(seen.begin(), seen.end(), '\n'), 1);
}

TEST_F(RunProgram, FramesAreListedWithTheirTimes) {
  ASSERT_EQ(run("run " + model() + " --duration 0.3 --out o --surfaces 3").code, 0);
  EXPECT_EQ(slurp(folder_ + "/o/frames.csv"),
            "frame,t,file\n0,0.099,surface-0000-t0.099000s.ply\n"
            "1,0.201,surface-0001-t0.201000s.ply\n2,0.3,surface-0002-t0.300000s.ply\n");
  for (const char* name : {"0-t0.099000s", "1-t0.201000s", "2-t0.300000s"})
    EXPECT_TRUE(std::filesystem::exists(folder_ + "/o/surface-000" + name + ".ply"));
}

TEST_F(RunProgram, OneLineTellsOfAllFilesThatWereWritten) {
  const ProgramResult result = run("run " + model() + " --duration 0.3 --out o --surfaces 50");
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(result.err.find("wrote"), result.err.rfind("wrote")) << result.err;
  EXPECT_NE(result.err.find("run.csv, report.json, 50 surfaces"), std::string::npos) << result.err;
}

TEST_F(RunProgram, AFreeBodySaysWhatItsLoadLoses) {
  const ProgramResult made = run_program(
      folder_, TREMOLO_BIN_DIR "/tremolo-precompute " + model_folder_ +
                   "/bar.veg -o free.tremolo --young 2e6 --density 1000 --fix none --load-at "
                   "'x>0.399' --load-force 0,0,-1 --linear-modes 4 --modes 6");
  ASSERT_EQ(made.code, 0) << made.err;
  const ProgramResult result = run("run free.tremolo --duration 0.1 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["rigid_modes"], 6);
  const double share = report["load_rigid_share"];
  EXPECT_GT(share, 0.2);
  EXPECT_LT(share, 1.0);
  EXPECT_NE(result.err.find("free body"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("% of what this load sets in motion (net force 1 N, torque"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(json::parse(run("run " + model() + " --duration 0.1 --json").out)["rigid_modes"], 0);
}

}  // namespace
}  // namespace tremolo
