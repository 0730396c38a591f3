// Every program's handling of the words of a command line.

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

class CommandWords : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }
  ProgramResult run(const std::string& command) {
    return run_program(folder_, "timeout -s KILL 60 " + command + " </dev/null");
  }

  std::string folder_;
};

const std::vector<std::string> kCommands = {
    kTremolo + "inspect",     kTremolo + "run",    kTremolo + "plot",
    kTremolo + "export",      kPrecompute,         kPrecompute + "reference",
    kPrecompute + "collider", kPrecompute + "tets"};

// The long flags with a value that a command's help lists.
std::set<std::string> valued_flags(const std::string& help) {
  std::set<std::string> flags;
  const std::regex line("^ +(?:-[a-zA-Z],)?(--[a-zA-Z-]+) (?:TEXT|FLOAT|INT|UINT|BOOLEAN|ENUM)",
                        std::regex::multiline);
  for (std::sregex_iterator at(help.begin(), help.end(), line), end; at != end; ++at)
    flags.insert((*at)[1]);
  return flags;
}

// An unset variable in a script gives an empty value, which is a mistake and not the same as no
// flag.
TEST_F(CommandWords, AnEmptyValueIsWrongUsageWhateverTheFlag) {
  std::size_t seen = 0;
  for (const std::string& command : kCommands) {
    const ProgramResult help = run(command + " --help");
    ASSERT_EQ(help.code, 0) << help.err;
    for (const std::string& flag : valued_flags(help.out)) {
      ++seen;
      for (const std::string& value : {flag + " ''", flag + "="}) {
        const ProgramResult result = run(command + " nowhere " + value);
        EXPECT_EQ(result.code, 2) << command << " " << value << "\n" << result.err;
      }
    }
  }
  EXPECT_GT(seen, 100U);
}

TEST_F(CommandWords, HelpAndVersionThatNobodyTakesAreAnError) {
  for (const std::string& command : kCommands)
    EXPECT_EQ(run("sh -c '" + command + " --help >/dev/full'").code, 1) << command;
  for (const std::string& program : {kTremolo, kPrecompute})
    EXPECT_EQ(run("sh -c '" + program + " --version >/dev/full'").code, 1) << program;
  std::ofstream(folder_ + "/cloth.toml") << "[[cloths]]\ncolumns = 3\nrows = 3\n";
  EXPECT_EQ(run(kTremolo + "inspect cloth.toml").code, 0);
  for (const std::string flags : {"", " --json"})
    EXPECT_EQ(run("sh -c '" + kTremolo + "inspect cloth.toml" + flags + " >/dev/full'").code, 1);
}

TEST_F(CommandWords, UnknownWordsAreToldInTheirOrderAndUnknownCommandsByName) {
  const ProgramResult words = run(kTremolo + "run x --one 1 --two --three");
  EXPECT_EQ(words.code, 2);
  EXPECT_NE(words.err.find("--one 1 --two --three"), std::string::npos) << words.err;
  const ProgramResult command = run(kTremolo + "frobnicate");
  EXPECT_EQ(command.code, 2);
  EXPECT_NE(command.err.find("frobnicate"), std::string::npos) << command.err;
  EXPECT_NE(command.err.find("inspect, run"), std::string::npos) << command.err;
}

TEST_F(CommandWords, ThreadsAndModesThatNobodyHasAreRefusedByTheirNumber) {
  std::ofstream(folder_ + "/w.toml") << "[[bodies]]\nname = \"a\"\nmodel = \"a.tremolo\"\n";
  for (const std::string& command :
       {kTremolo + "run w.toml --threads 1000000", kTremolo + "run w.toml --threads -1",
        kPrecompute + "a.msh -o a.tremolo --threads 1000000",
        kTremolo + "export a.tremolo --glb a.glb --modes -1"}) {
    const ProgramResult result = run(command);
    EXPECT_EQ(result.code, 2) << command << "\n" << result.err;
    EXPECT_EQ(result.err.find("memory"), std::string::npos) << result.err;
  }
}

TEST_F(CommandWords, FlagsOfTheReferenceStandInNoOtherHelp) {
  EXPECT_EQ(run(kPrecompute + "--help").out.find("--fix-x"), std::string::npos);
  EXPECT_NE(run(kPrecompute + "reference --help").out.find("--fix-x"), std::string::npos);
  const ProgramResult result = run(kPrecompute + "a.msh -o a.tremolo --fix-x 'x<1'");
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("reference"), std::string::npos) << result.err;
}

// Names of files and in files reach the terminal as text alone.
TEST_F(CommandWords, EscapeCodesInNamesAreTold) {
  std::ofstream(folder_ + "/s.toml") << "[[bodies]]\nname = \"a\\u001b[2Jb\"\nmodel = \"x\"\n";
  for (const std::string& command :
       {kTremolo + "run s.toml", kTremolo + "inspect \"$(printf 'a\\033[2Jb')\"",
        kPrecompute + "\"$(printf 'a\\033[2Jb.msh')\" -o a.tremolo"}) {
    const ProgramResult result = run(command);
    EXPECT_NE(result.code, 0) << command;
    EXPECT_EQ(result.err.find('\x1b'), std::string::npos) << command;
    EXPECT_NE(result.err.find("\\x1b[2Jb"), std::string::npos) << command << "\n" << result.err;
  }
}

// A fake apt-get whose lock another program holds twice.
TEST_F(CommandWords, SetUpWaitsForWhoeverHoldsApt) {
  std::ofstream(folder_ + "/apt-get") << R"(#!/bin/sh
n=$(cat count 2>/dev/null || echo 0); echo $((n + 1)) >count
[ "$n" -lt 2 ] || exit 0
echo 'E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1 (apt)' >&2
exit 100
)";
  std::ofstream(folder_ + "/broken") << "#!/bin/sh\necho 'E: no network' >&2\nexit 100\n";
  for (const char* name : {"apt-get", "broken"})
    std::filesystem::permissions(folder_ + "/" + name, std::filesystem::perms::owner_all);
  const std::string source = "sudo() { \"$@\"; }; . " TREMOLO_SOURCE_DIR "/cmake/setup.sh; ";
  const ProgramResult waited =
      run("env PATH=.:$PATH bash -c '" + source + "apt_get update && echo done'");
  EXPECT_EQ(waited.code, 0) << waited.err;
  EXPECT_NE(waited.out.find("held by process 1"), std::string::npos) << waited.out;
  EXPECT_EQ(slurp(folder_ + "/count"), "3\n");
  std::filesystem::rename(folder_ + "/broken", folder_ + "/apt-get");
  const ProgramResult failed = run("env PATH=.:$PATH bash -c '" + source + "apt_get update'");
  EXPECT_EQ(failed.code, 1);
  EXPECT_NE(failed.err.find("no network"), std::string::npos) << failed.err;
}

}  // namespace

// `tremolo inspect SCENE`: positions, contacts, steps that resolve the vibration; keyframes.

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
  const nlohmann::json report = inspected(kCube + "position = [1, 2, 0.001]\n" + floor());
  ASSERT_EQ(report["bodies"].size(), 1u);
  EXPECT_NEAR(report["bodies"][0]["low"][2].get<double>(), 0.001, 1e-12);
  EXPECT_NEAR(report["bodies"][0]["high"][0].get<double>(), 1.2, 1e-12);
  EXPECT_GT(report["bodies"][0]["first_mode_hz"].get<double>(), 1.0);
  EXPECT_NEAR(report["bodies"][0]["steps_a_period"].get<double>() * 0.01 *
                  report["bodies"][0]["first_mode_hz"].get<double>(),
              1.0, 1e-9);
  ASSERT_EQ(report["contacts"].size(), 1u);
  EXPECT_EQ(report["contacts"][0]["collider"], "floor");
  EXPECT_NEAR(report["contacts"][0]["distance_m"].get<double>(), 0.001, 1e-9);
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

TEST_F(InspectScene, EscapeCodesInTheNameOfTheSceneAreShownAsText) {
  std::ofstream(folder_ + "/a\033[2Jb.toml") << kCube + "position = [1, 2, 0.5]\n" + floor();
  const ProgramResult result =
      run_program(folder_, kTremolo + "inspect \"$(printf 'a\\033[2Jb.toml')\"");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out.find('\033'), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("a\\x1b[2Jb.toml"), std::string::npos) << result.out;
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
