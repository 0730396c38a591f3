// Whatever goes wrong while an output is written, each file is afterwards the old one or a complete
// new one, and the program says which file it could not write.
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

const std::string kArguments =
    " --fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-1 --linear-modes 4 --modes 8 "
    "--threads 1 --order 1 ";
const std::string kOlder = "an older file that must survive";

#ifdef TREMOLO_LONG_TESTS
constexpr int kStride = 1;
#else
constexpr int kStride = 3;
#endif

using Files = std::map<std::string, std::string>;  // name -> bytes

Files files_in(const std::string& folder) {
  Files files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = slurp(entry.path().string());
  return files;
}

// Times and folders differ from run to run; the rest of a report does not.
std::string without_times(const std::string& name, const std::string& bytes) {
  if (!name.ends_with(".json")) return bytes;
  nlohmann::json report = nlohmann::json::parse(bytes, nullptr, false);
  if (!report.is_object()) return bytes;
  report.erase("microseconds_per_step");
  report.erase("real_time_factor");
  report.erase("files");
  return report.dump();
}

class Faults : public ::testing::Test {
 protected:
  // bar.veg and bar.tremolo, which all tests read.
  static void SetUpTestSuite() {
    source_ = fresh_folder();
    testing::write_veg(source_ + "/bar.veg", testing::box_mesh({6, 2, 2}, {0.4, 0.05, 0.06}));
    const ProgramResult made =
        run_program(source_, kPrecompute + "bar.veg -o bar.tremolo --young 2e6" + kArguments);
    ASSERT_EQ(made.code, 0) << made.err;
    ASSERT_EQ(run_program(source_, kTremolo + "run bar.tremolo --duration 0.1 --out was").code, 0);
  }

  // A folder OUT of its own for the command's results, with an old file for each name.
  void prepare() {
    work_ = fresh_folder();
    out_ = work_ + "/out";
    fs::create_directory(out_);
    for (const std::string& name : names_) std::ofstream(out_ + "/" + name) << kOlder;
  }

  ProgramResult run(const std::string& environment) {
    std::string command = command_;
    for (std::size_t at; (at = command.find("OUT")) != std::string::npos;)
      command.replace(at, 3, out_);
    for (std::size_t at; (at = command.find("SOURCE")) != std::string::npos;)
      command.replace(at, 6, source_);
    return run_program(work_, environment + command);
  }

  // The Nth call of its sort fails; nullopt if there is no Nth.
  std::optional<ProgramResult> run_with(const std::string& fault, int number) {
    prepare();
    const std::string mark = work_ + "/came";
    ProgramResult result = run("LD_PRELOAD=" TREMOLO_FAULTY_IO
                               " ASAN_OPTIONS=verify_asan_link_order=0 "
                               "TREMOLO_FAULT_AT=" +
                               fs::canonical(out_).string() + "/ TREMOLO_FAULT=" + fault + ":" +
                               std::to_string(number) + " TREMOLO_FAULT_MARK=" + mark + " ");
    if (!fs::exists(mark)) return std::nullopt;
    return result;
  }

  void expect_old_or_new(const std::string& what, bool partials_allowed) {
    for (const auto& [name, bytes] : files_in(out_)) {
      if (name.find(".partial-") != std::string::npos) {
        EXPECT_TRUE(partials_allowed) << what << " left " << name;
        continue;
      }
      EXPECT_TRUE(bytes == kOlder || without_times(name, bytes) == without_times(name, new_[name]))
          << what << ": " << name << " is neither the old nor the new one";
    }
  }

  // Every fault at every place where it can occur; in the short form at the first three and at each
  // third behind them.
  void survives_everything(const std::string& command, std::vector<std::string> names) {
    command_ = command;
    names_ = std::move(names);
    prepare();
    const ProgramResult good = run("");
    ASSERT_EQ(good.code, 0) << good.err;
    new_ = files_in(out_);
    for (const std::string& name : names_)
      ASSERT_NE(new_[name], kOlder) << name << " is not written";
    for (const std::string fault : {"write-short", "write-eintr", "fsync-eintr"}) came(fault, 0);
    for (const std::string fault :
         {"write-full", "open-full", "fsync-fail", "rename-fail", "close-fail"})
      came(fault, 1);
    for (const std::string fault : {"write-kill", "fsync-kill", "rename-kill"}) came(fault, 137);
  }

  void came(const std::string& fault, int code) {
    int number = 1;
    for (; const auto result = run_with(fault, number); number += number < 3 ? 1 : kStride) {
      const std::string what = fault + ":" + std::to_string(number);
      EXPECT_EQ(result->code, code) << what << "\n" << result->err;
      expect_old_or_new(what, code == 137);
      if (code == 1) {
        EXPECT_NE(result->err.find(out_), std::string::npos) << what << ": no path in\n"
                                                             << result->err;
      }
      if (code != 137) continue;
      EXPECT_EQ(run("").code, 0) << what;
      for (const auto& [name, bytes] : files_in(out_))
        EXPECT_EQ(name.find(".partial-"), std::string::npos)
            << what << ": the next run left " << name;
    }
    EXPECT_GT(number, 1) << fault << " never came";
  }

  static inline std::string source_;
  std::string command_, work_, out_;
  std::vector<std::string> names_;
  Files new_;
};

TEST_F(Faults, PrecomputeLeavesTheOldFileOrTheNewOne) {
  survives_everything(kPrecompute + "SOURCE/bar.veg -o OUT/a.tremolo" + kArguments, {"a.tremolo"});
  came("open-term", 143);
}

TEST_F(Faults, RunLeavesOldFilesOrNewOnes) {
  survives_everything(kTremolo + "run SOURCE/bar.tremolo --duration 0.1 --out OUT --surfaces 2",
                      {"run.csv", "report.json", "frames.csv", "surface-0000-t0.051000s.ply",
                       "surface-0001-t0.099000s.ply"});
}

TEST_F(Faults, ExportLeavesOldFilesOrNewOnes) {
  survives_everything(
      kTremolo +
          "export SOURCE/bar.tremolo --duration 0.1 --rate 20 --glb OUT/a.glb "
          "--usda OUT/a.usda --mdd OUT/b.mdd --pc2 OUT/c.pc2 "
          "--series OUT/d.ply",
      {"a.glb", "a.usda", "b.mdd", "b.obj", "c.pc2", "c.obj", "d.csv", "d-0000.ply", "d-0002.ply"});
}

TEST_F(Faults, PlotLeavesTheOldPictureOrTheNewOne) {
  survives_everything(kTremolo + "plot SOURCE/was -o OUT/a.html", {"a.html"});
  came("open-term", 143);
}

// ulimit counts blocks of 512 or 1024 bytes: enough for messages, too little for any output here.
TEST_F(Faults, ALimitOnFileSizesIsAnErrorWithAPath) {
  for (const auto& [command, name] : std::map<std::string, std::string>{
           {kPrecompute + "SOURCE/bar.veg -o OUT/a" + kArguments, "a"},
           {kTremolo + "run SOURCE/bar.tremolo --duration 0.5 --out OUT", "run.csv"},
           {kTremolo + "export SOURCE/bar.tremolo --duration 1 --glb OUT/a.glb", "a.glb"},
           {kTremolo + "run SOURCE/bar.tremolo --duration 0.1 --out OUT --surfaces 1",
            "surface-0000-t0.099000s.ply"}}) {
    command_ = command;
    names_ = {name};
    prepare();
    const ProgramResult result = run("ulimit -f 4; ");
    EXPECT_EQ(result.code, 1) << command << result.err;
    EXPECT_NE(result.err.find(out_ + "/" + name), std::string::npos) << result.err;
    EXPECT_EQ(files_in(out_), (Files{{name, kOlder}})) << command;
  }
}

TEST_F(Faults, AFullStandardOutputIsAnError) {
  for (const std::string& command :
       {kTremolo + "inspect SOURCE/bar.tremolo --json", kTremolo + "inspect SOURCE/bar.tremolo",
        kTremolo + "run SOURCE/bar.tremolo --duration 0.1 --json",
        kTremolo + "export SOURCE/bar.tremolo --duration 0.1 --glb OUT/a.glb",
        kPrecompute + "SOURCE/bar.veg --json -o OUT/a" + kArguments}) {
    command_ = "(" + command + " > /dev/full)";
    names_ = {};
    prepare();
    const ProgramResult result = run("");
    EXPECT_EQ(result.code, 1) << command;
    EXPECT_NE(result.err.find("standard output"), std::string::npos) << result.err;
  }
}

TEST_F(Faults, APrecomputeThatIsKilledAtAnyMomentLeavesTheOldFileAndTheNextOneSucceeds) {
  command_ = "SOURCE/bar.veg -o OUT/a.tremolo" + kArguments;
  names_ = {"a.tremolo"};
  const std::string arguments = command_;
  prepare();
  command_ = kPrecompute + arguments;
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run("").code, 0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
  new_ = files_in(out_);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> moment(0.0, 1.1 * whole.count());
  for (int trial = 0; trial < 12; ++trial) {
    const bool hard = trial % 2 == 0;
    prepare();
    command_ = std::string("timeout -s ") + (hard ? "KILL " : "TERM ") +
               std::to_string(moment(random) + 1e-3) + " " + kPrecompute + arguments;
    const ProgramResult result = run("");
    // 124 is timeout's own word for SIGTERM.
    EXPECT_TRUE(result.code == 0 || result.code == (hard ? 137 : 124)) << result.code << result.err;
    expect_old_or_new(command_, hard);
    command_ = kPrecompute + arguments;
    EXPECT_EQ(run("").code, 0);
    EXPECT_EQ(files_in(out_), new_);
  }
}

}  // namespace
}  // namespace tremolo
