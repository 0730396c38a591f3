// Every program's handling of the words of a command line.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

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
      for (const std::string& value : {flag + " ''", flag + "=", flag + "=''"}) {
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
}  // namespace tremolo
