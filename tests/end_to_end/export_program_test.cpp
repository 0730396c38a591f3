// The output of `tremolo export` for a run, read by tests/exchange/read_exports.py, which follows
// the formats' specifications, and compared with the surfaces of `tremolo run`.
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/frames/bar_skin.h"
#include "tests/support/programs.h"
#include "tests/support/text_lines.h"

namespace tremolo {
namespace {

using nlohmann::json;
using testing::kBar;

constexpr const char* kPython = "/usr/bin/python3";
const std::string kReader =
    std::string(kPython) + " " + TREMOLO_SOURCE_DIR + "/tests/exchange/read_exports.py ";

// Steps of which whole numbers fit between frames, so that PC2's are where it says.
const std::string kTimes = " --step 0.0025 --duration 0.5 ";

class ExportProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    made_ = testing::make_drawn_bar(folder_);
    if (made_.code == 0)
      made_ = run_program(folder_, kPrecompute + kBar + "-o free.tremolo --fix none");
    std::ofstream(folder_ + "/world.toml")
        << kWorld << free_body("thrown", "position = [0, 0, 0.3]\nspin = [3, 14, 5]\n")
        << free_body("also", "position = [0, 1, 0.2]\nvelocity = [0.4, 0, 0]\n");
  }
  void SetUp() override { ASSERT_EQ(made_.code, 0) << made_.err; }

  static ProgramResult run(const std::string& command) { return run_program(folder_, command); }
  static bool there(const std::string& name) {
    return std::filesystem::exists(folder_ + "/" + name);
  }
  static bool has_python() { return std::filesystem::exists(kPython); }

  static json exported(const std::string& flags) {
    const ProgramResult result = run(kTremolo + "export " + flags + " --json");
    EXPECT_EQ(result.code, 0) << flags << ": " << result.err;
    return json::parse(result.out, nullptr, false);
  }
  static json checked(const std::string& glb) {
    const ProgramResult result = run(kReader + "check " + glb);
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  // Floats know seven digits of a coordinate, and bodies here stay within some times their size.
  static void expect_same(const std::string& file, const std::string& body,
                          const std::string& surfaces) {
    const ProgramResult result =
        run(kReader + "compare " + file + " " + body + " " + surfaces + " 1e-6");
    EXPECT_EQ(result.code, 0) << result.out << result.err;
  }
  static void expect_refused(const std::string& flags, int code, const std::string& word) {
    const ProgramResult result = run(kTremolo + "export " + flags);
    EXPECT_EQ(result.code, code) << flags << ": " << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    EXPECT_FALSE(there("no.glb") || there("no.html")) << flags;
  }
  // Each list of flags ends with the exit code and the word next to it.
  static void expect_refused(
      std::initializer_list<std::tuple<std::string, int, std::string>> rows) {
    for (const auto& [flags, code, word] : rows) expect_refused(flags, code, word);
  }

  static constexpr const char* kWorld = R"(duration = 0.5
step = 0.0025
gravity = [0, 0, -9.81]
[[bodies]]
name = "shaken"
model = "bar.tremolo"
kind = "driven"
contact = false
[[bodies.motion]]
kind = "shake"
amplitude = [0, 0, 0.01]
frequency = 6
start = 0
[[colliders]]
name = "floor"
shape = "plane"
[[colliders]]
name = "ball"
shape = "sphere"
radius = 0.05
position = [-1, 0, 0.2]
[[colliders.motion]]
kind = "glide"
velocity = [0.5, 0, 0]
)";
  static std::string free_body(const std::string& name, const std::string& keys) {
    return "[[bodies]]\nname = \"" + name +
           "\"\nmodel = \"free.tremolo\"\nkind = \"free\"\nbeta = 0.0005\n" + keys;
  }

  static inline std::string folder_;
  static inline ProgramResult made_;
};

TEST_F(ExportProgram, EveryFormatHasTheSurfacesOfARun) {
  if (!has_python()) GTEST_SKIP() << "no " << kPython;
  ASSERT_EQ(run(kTremolo + "run bar.tremolo" + kTimes + "--surfaces 5 --out run").code, 0);
  const json report = exported("bar.tremolo" + kTimes +
                               "--rate 40 --glb bar.glb --pc2 bar.pc2 --mdd bar.mdd --pvd bar.pvd "
                               "--usda bar.usda --series bar.ply");
  EXPECT_EQ(report["frames"], 21);
  EXPECT_LT(report["offset"].get<double>(), 1e-12);
  for (const char* file : {"bar.glb", "bar.pc2@40", "bar.mdd", "bar.pvd", "bar.usda", "bar.csv"})
    expect_same(file, "bar", "run");
  // The rest shape of the caches: one object, though the skin has three. Its vertices are those of
  // the cache, in their number (at byte 16); texture coordinates may be more.
  const std::string rest = testing::slurp(folder_ + "/bar.obj");
  EXPECT_EQ(testing::lines_with(rest, "o"), std::vector<std::string>{"o bar"});
  const std::string cache = testing::slurp(folder_ + "/bar.pc2");
  std::int32_t points = 0;
  ASSERT_GT(cache.size(), 20U);
  std::memcpy(&points, cache.data() + 16, sizeof(points));
  EXPECT_EQ(testing::lines_with(rest, "v").size(), static_cast<std::size_t>(points));
  EXPECT_GE(testing::lines_with(rest, "vt").size(), testing::lines_with(rest, "v").size());
}

TEST_F(ExportProgram, AGlbHasMaterialsAndTextureCoordinatesAndBoundedWeights) {
  if (!has_python()) GTEST_SKIP() << "no " << kPython;
  const json report = exported("bar.tremolo" + kTimes + "--glb bar.glb");
  EXPECT_LE(report["files"][0]["position_error"].get<double>(), 1e-6);
  const json body = checked("bar.glb")["bodies"][0];
  EXPECT_EQ(body["primitives"], 2) << "rubber and steel";
  EXPECT_EQ(body["attributes"], json({"NORMAL", "POSITION", "TEXCOORD_0"}));
  EXPECT_EQ(body["targets"], 6);
  EXPECT_EQ(body["weights"], json({0.0, 1.0}));
  EXPECT_EQ(body["triangles"], 12);
  // Without optional parts.
  exported("bar.tremolo" + kTimes + "--glb small.glb --plain-weights --no-normals --modes 2");
  const json small = checked("small.glb")["bodies"][0];
  EXPECT_EQ(small["attributes"], json({"POSITION", "TEXCOORD_0"}));
  EXPECT_EQ(small["targets"], 2);
  EXPECT_LT(small["weights"][1].get<double>(), 0.5);
}

TEST_F(ExportProgram, AWorldHasItsBodiesAndCollidersWhereTheyAre) {
  if (!has_python()) GTEST_SKIP() << "no " << kPython;
  ASSERT_EQ(run(kTremolo + "run world.toml --surfaces 5 --out world").code, 0);
  exported("world.toml --rate 40 --glb w.glb --pc2 w.pc2 --mdd w.mdd --pvd w.pvd --usda w.usda");
  for (const std::string body : {"thrown", "also", "shaken"})
    for (const std::string& file :
         {std::string("w.glb"), "w-" + body + ".pc2@40", "w-" + body + ".mdd", std::string("w.pvd"),
          std::string("w.usda")})
      expect_same(file, body, "world/" + body);
  const json all = checked("w.glb")["bodies"];
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all[3]["name"], "floor");
  EXPECT_EQ(all[4]["name"], "ball");
  exported("world.toml --rate 40 --glb w.glb --no-colliders");
  EXPECT_EQ(checked("w.glb")["bodies"].size(), 3U);
}

TEST_F(ExportProgram, ARangeAndItsTimesAreExact) {
  const json report = exported(
      "bar.tremolo --step 0.003 --duration 1 --from 0.2 --to 0.4 "
      "--rate 60 --mdd range.mdd --series range.obj");
  EXPECT_EQ(report["frames"], 13);
  EXPECT_EQ(report["first"], 67 * 0.003) << "the step nearest to 0.2 s";
  EXPECT_NEAR(report["last"].get<double>(), 0.399, 1e-12);
  EXPECT_GT(report["offset"].get<double>(), 0.0);
  EXPECT_LE(report["offset"].get<double>(), 0.0015 + 1e-12);
  EXPECT_NE(testing::slurp(folder_ + "/range.csv").find("0,0.201,bar,range-0000.obj"),
            std::string::npos);
}

TEST_F(ExportProgram, WhatFewerCoordinatesLeaveOutIsTold) {
  const json all = exported("bar.tremolo" + kTimes + "--glb a.glb --modes 6");
  EXPECT_EQ(all["left_out_error"], 0.0);
  const json some = exported("bar.tremolo" + kTimes + "--glb a.glb --modes 1");
  EXPECT_GT(some["left_out_error"].get<double>(), 0.0);
  EXPECT_LT(some["left_out_error"].get<double>(), 0.1);
  const ProgramResult result =
      run(kTremolo + "export bar.tremolo" + kTimes + "--glb a.glb --modes 1");
  EXPECT_NE(result.err.find("the first 1 coordinates"), std::string::npos) << result.err;
}

TEST_F(ExportProgram, WrongUseIsSaidAndNothingIsWritten) {
  const std::string bar = "bar.tremolo" + kTimes;
  expect_refused({
      {"bar.tremolo", 2, "--glb"},
      {bar + "--glb no.gltf", 2, ".glb"},
      {bar + "--series no.stl", 2, ".ply or .obj"},
      {bar + "--page no.htm", 2, ".html"},
      {bar + "--glb no.glb --note text", 2, "apply only to --page"},
      {bar + "--page no.html --runs nowhere", 1, "nowhere"},
      {bar + "--glb no.glb --rate 500", 3, "--step 0.002"},
      {bar + "--glb no.glb --from 2", 3, "range"},
      {bar + "--glb no.glb --to 2", 3, "--duration"},
      {bar + "--glb no.glb --texture skin.obj", 3, "skin.obj"},
      {bar + "--glb no.glb --texture gold=skin.obj", 2, "'rubber', 'steel'"},
      {"world.toml --cub no.cub --glb no.glb", 2, "not to a scene"},
      {"world.toml --glb no.glb --load sine", 2, "--load"},
      {"nothing.tremolo --glb no.glb", 1, "nothing.tremolo"},
      {bar + "--glb folder/no.glb", 1, "folder/no.glb"},
  });
  // A method that explodes: the exit code is the run's.
  expect_refused("bar.tremolo --integrator explicit-euler --step 0.01 --duration 5 --glb no.glb", 5,
                 "energy");
  // An input file is not overwritten.
  std::filesystem::copy_file(folder_ + "/bar.tremolo", folder_ + "/bar.usda.tremolo");
  std::filesystem::create_hard_link(folder_ + "/bar.usda.tremolo", folder_ + "/linked.glb");
  expect_refused("bar.usda.tremolo" + kTimes + "--glb linked.glb", 2, "take the place");
}

TEST_F(ExportProgram, WhatItWroteBeforeItStillWrites) {
  const ProgramResult both = run(kTremolo +
                                 "export bar.tremolo --vtu modes.vtu --duration 0.1 "
                                 "--glb both.glb");
  EXPECT_EQ(both.code, 0) << both.err;
  EXPECT_TRUE(there("modes.vtu"));
  EXPECT_TRUE(there("both.glb"));
  std::ofstream(folder_ + "/one.toml")
      << "[bar]\nmodel = \"bar.tremolo\"\nduration = 0.2\nstep = 0.0025\n";
  const json report = exported("one.toml --glb one.glb --load sine");
  EXPECT_EQ(report["last"], 0.2);
}

TEST_F(ExportProgram, APageTellsHowFarItIsFromTheRun) {
  ASSERT_EQ(run(kTremolo + "run bar.tremolo --load sine --duration 0.2 --out ran").code, 0);
  for (const char* source :
       {"bar.tremolo --load sine --duration 0.2", "world.toml --duration 0.2"}) {
    const json report = exported(std::string(source) + " --page a.html --runs ran --note 'a `b`'");
    ASSERT_EQ(report["files"].size(), 1U) << source;
    EXPECT_EQ(report["files"][0]["format"], "page") << source;
    EXPECT_LE(report["files"][0]["position_error"], 1e-5) << source;
    EXPECT_EQ(report["files"][0]["bytes"], std::filesystem::file_size(folder_ + "/a.html"));
  }
}

}  // namespace
}  // namespace tremolo
