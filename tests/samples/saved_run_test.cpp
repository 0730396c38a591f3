// `tremolo run --save` and `--restore` of a basis file, a table per body and a world: a run that is
// divided at a random step writes what the undivided one does from there on.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kSteps = 200;
constexpr double kStep = 0.001;

class SavedRun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    models_ = testing::fresh_folder();
    testing::write_veg(models_ + "/bar.veg", box_mesh({6, 2, 2}, {0.4, 0.05, 0.06}));
    for (const char* what : {"--fix 'x<0.001' -o held.tremolo", "--fix none -o free.tremolo"}) {
      const ProgramResult made = run_program(
          models_, kPrecompute +
                       "bar.veg --young 2e6 --density 1000 --load-at 'x>0.399' --load-force "
                       "0,0,-1 --linear-modes 5 --modes 9 --order 1 " +
                       what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult run(const std::string& flags, int steps = kSteps, double step = kStep) {
    return run_program(
        folder_, kTremolo + "run " + file_ +
                     fmt::format(" --json --step {} --duration {} ", step, steps * step) + flags);
  }
  std::string text_of(const std::string& name) { return slurp(folder_ + "/" + name); }

  // Every surface of `rest` is one of `whole`; returns their number.
  int same_surfaces(const std::string& whole, const std::string& rest) {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder_ + "/" + rest)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with("surface-")) continue;
      ++count;
      EXPECT_EQ(text_of(whole + "/" + name), text_of(rest + "/" + name)) << name;
    }
    return count;
  }
  void same_rows(const std::string& whole, const std::string& rest, int rows) {
    std::string tail = text_of(rest + "/run.csv");
    tail.erase(0, tail.find('\n') + 1);
    EXPECT_EQ(std::count(tail.begin(), tail.end(), '\n'), rows);
    EXPECT_TRUE(text_of(whole + "/run.csv").ends_with(tail));
  }

  static inline std::string models_;
  std::string folder_, file_ = models_ + "/held.tremolo";
};

TEST_F(SavedRun, OfASingleBodyGoesOnWithTheSameBits) {
  std::mt19937 random(20);
  for (const std::string flags :
       {"--integrator ep4", "--integrator ep4 --beta 0.001 --load sine --frequency 7",
        "--integrator avf --damping-ratio 2%,1%,3% --start static --load constant",
        "--integrator imexv --alpha 0.5 --load impulse --scale 3",
        "--integrator imexv-adaptive --scale 5", "--integrator verlet --load sine --modes 2",
        "--integrator newmark --newmark-gamma 0.6 --newmark-beta 0.31",
        "--integrator midpoint --rescale young=1e6",
        "--integrator rk4 --modes 2 --load chirp --load-duration 0.15 --linear",
        "--integrator ep2 --at 'x>0.399' --force 0,1,0 --scale 0.7"}) {
    const int cut = std::uniform_int_distribution<int>(1, kSteps - 1)(random);
    SCOPED_TRACE(flags + fmt::format(", divided after step {}", cut));
    const std::string all = flags + " --coordinate all --velocities --surfaces 8 ";
    const ProgramResult whole = run(all + "--out whole --save whole.saved");
    ASSERT_EQ(whole.code, 0) << whole.err;
    ASSERT_EQ(run(flags + " --save cut.saved", cut).code, 0);
    const ProgramResult rest = run(all + "--out rest --restore cut.saved --save rest.saved");
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(text_of("whole.saved"), text_of("rest.saved"));
    same_rows("whole", "rest", kSteps - cut + 1);
    EXPECT_EQ(same_surfaces("whole", "rest"), 8 - 8 * cut / kSteps);
    const json one = json::parse(whole.out), other = json::parse(rest.out);
    for (const char* key :
         {"steps", "reached", "duration", "iterations_per_step", "halved_steps", "work",
          "dissipated", "energy_initial", "energy_final", "high_band_final", "low_modes"})
      EXPECT_EQ(one[key], other[key]) << key;
  }
}

TEST_F(SavedRun, OfATableIsTheSame) {
  file_ = "scene.toml";
  std::ofstream(folder_ + "/scene.toml")
      << "[bar]\nmodel = \"" + models_ + "/held.tremolo\"\nload = \"sine\"\nbeta = 0.001\n";
  ASSERT_EQ(run("--out whole --save whole.saved").code, 0);
  ASSERT_EQ(run("--save cut.saved --threads 2", 77).code, 0);
  const ProgramResult rest = run("--out rest --restore cut.saved --save rest.saved --threads 0");
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_EQ(text_of("whole.saved"), text_of("rest.saved"));
  same_rows("whole", "rest", kSteps - 77 + 1);
}

TEST_F(SavedRun, OfABodyThatMeetsAFloorIsTheSame) {
  file_ = "scene.toml";
  std::ofstream(folder_ + "/scene.toml")
      << "gravity = [0, 0, -9.81]\n[[bodies]]\nname = \"bar\"\nkind = \"free\"\nmodel = \"" +
             models_ +
             "/free.tremolo\"\nvelocity = [0, 0, -1]\nbeta = 0.001\nrestitution = 0.5\n"
             "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nposition = [0, 0, -0.1]\n";
  for (const int cut : {30, 111, 190}) {
    ASSERT_EQ(run("--out whole --surfaces 5 --save whole.saved").code, 0);
    ASSERT_EQ(run("--save cut.saved", cut).code, 0);
    const ProgramResult rest = run("--out rest --surfaces 5 --restore cut.saved --save rest.saved");
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_GT(json::parse(rest.out)["bodies"][0]["contacts"], 0);
    EXPECT_EQ(text_of("whole.saved"), text_of("rest.saved"));
    same_rows("whole/bar", "rest/bar", kSteps - cut + 1);
    EXPECT_EQ(same_surfaces("whole/bar", "rest/bar"), 5 - 5 * cut / kSteps);
  }
}

// The energy of a restored run is compared with that at its start, not with zero.
TEST_F(SavedRun, ThatIsFreeOfLoadsMeasuresItsDrift) {
  ASSERT_EQ(run("--load impulse --integrator ep4 --save cut.saved", 100).code, 0);
  const ProgramResult rest = run("--load impulse --integrator ep4 --restore cut.saved");
  ASSERT_EQ(rest.code, 0) << rest.err;
  const json report = json::parse(rest.out);
  EXPECT_GT(report["energy_final"], 0.0);
  EXPECT_NEAR(report["energy_reference"].get<double>(), report["energy_final"].get<double>(),
              1e-9 * report["energy_final"].get<double>());
  EXPECT_LE(report["energy_drift_max"].get<double>(), 1e-9);
}

// Also if its duration is not a multiple of the step: 66.67 steps are 67.
TEST_F(SavedRun, ThatIsAtItsEndIsAtItsEndAgain) {
  const std::string command = kTremolo + "run " + file_ + " --json --step 0.003 --duration 0.2 ";
  ASSERT_EQ(run_program(folder_, command + "--save end.saved").code, 0);
  const ProgramResult again =
      run_program(folder_, command + "--restore end.saved --save again.saved");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(json::parse(again.out)["steps"], 67);
  EXPECT_EQ(text_of("end.saved"), text_of("again.saved"));
}

TEST_F(SavedRun, ThatDoesNotBelongIsRefused) {
  ASSERT_EQ(run("--save cut.saved", 100).code, 0);
  const auto refused = [this](const std::string& flags, int code, const std::string& words,
                              int steps = kSteps, double step = kStep) {
    const ProgramResult result = run(flags + " --out never", steps, step);
    EXPECT_EQ(result.code, code) << flags << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder_ + "/never/run.csv"));
  };
  refused("--restore cut.saved --load sine", 3, "another body 'held'");
  refused("--restore cut.saved --scale 2", 3, "another body 'held'");
  refused("--restore cut.saved --beta 0.1", 3, "another body 'held'");
  refused("--restore cut.saved", 3, "another step or gravity", kSteps, 2.0 * kStep);
  refused("--restore cut.saved", 3, "behind the duration", 50);
  refused("--restore cut.saved --deflect 5%", 2, "--scale");
  refused("--restore cut.saved --save cut.saved", 2, "cut.saved");
  refused("--restore none.saved", 1, "none.saved");
  refused("--save missing/one.saved", 1, "missing");
  file_ = "scene.toml";
  std::string scene;
  for (const char* name : {"one", "two"})
    scene += "[" + std::string(name) + "]\nmodel = \"" + models_ + "/held.tremolo\"\n";
  std::ofstream(folder_ + "/scene.toml") << scene;
  refused("--save two.saved", 2, "--save applies only to one body");
  refused("--restore cut.saved", 2, "--restore applies only to one body");
}

}  // namespace
}  // namespace tremolo
