// No output of any program replaces an input, whatever its name; unwritable outputs are reported
// before the first step; files of earlier runs do not mix with those of a run.
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A run that would take hours: errors are reported before it.
const std::string kHours = " --duration 1e6 ";

class KeptInputs : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    models_ = fresh_folder();
    write_veg(models_ + "/bar.veg", box_mesh({4, 1, 1}, {0.4, 0.05, 0.06}));
    for (const char* what : {"--fix 'x<0.001' -o bar.tremolo", "--fix none -o free.tremolo"}) {
      const ProgramResult made = run_program(
          models_, kPrecompute +
                       "bar.veg --load-at 'x>0.399' --load-force 0,0,-1 --linear-modes 3 "
                       "--modes 3 --order 1 " +
                       what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
    const ProgramResult tets =
        run_program(models_, kPrecompute + "tets bar.veg --fix 'x<0.001' -o bar.tets");
    ASSERT_EQ(tets.code, 0) << tets.err;
  }

  void SetUp() override {
    folder_ = fresh_folder();
    for (const char* name : {"bar.tremolo", "free.tremolo", "bar.tets"})
      fs::copy(models_ + "/" + name, folder_);
  }

  std::string at(const std::string& name) const { return folder_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(at(name)).parent_path());
    std::ofstream(at(name)) << text;
  }
  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, "timeout -s KILL 60 " + kTremolo + arguments);
  }
  // The file names below a folder.
  std::set<std::string> names_in(const std::string& name) const {
    std::set<std::string> names;
    std::error_code none;
    for (const auto& entry : fs::recursive_directory_iterator(at(name), none))
      if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), at(name)).string());
    return names;
  }

  void expect_refused(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << arguments << "\n" << result.err;
  }
  // The command is refused, and the file is as it was.
  void expect_kept(const std::string& arguments, const std::string& file) {
    const std::string before = slurp(at(file));
    ASSERT_FALSE(before.empty()) << file;
    expect_refused(arguments, 2, "would take the place of");
    EXPECT_EQ(slurp(at(file)), before) << arguments;
  }

  static std::string world(const std::string& keys, const std::string& name = "a",
                           const std::string& model = "free.tremolo") {
    return "duration = 0.03\n[[bodies]]\nname = \"" + name + "\"\nkind = \"free\"\nmodel = \"" +
           model + "\"\n" + keys;
  }
  static std::string cloth(const std::string& mesh, const std::string& name = "sheet") {
    return "duration = 0.1\nstep = 0.01\n[[cloths]]\nname = \"" + name + "\"\nfile = \"" + mesh +
           "\"\n";
  }

  static inline std::string models_;
  std::string folder_;
};

const std::string kSheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

TEST_F(KeptInputs, AClothsMeshIsNoSurfaceOfAnEarlierRun) {
  for (const char* mesh : {"out/sheet/surface-0000-t0.050000s.obj", "out/surface-0001.obj"}) {
    write(mesh, kSheet);
    write("scene.toml", cloth(mesh));
    expect_kept("run scene.toml --out out --surfaces 1 --surface-format obj", mesh);
    expect_kept("run scene.toml --out out", mesh);
  }
}

TEST_F(KeptInputs, FilesThatPartsOfAWorldNameAreInputs) {
  write("out/a/frames.csv", "0,0,0,-9.81\n1,0,0,-9.81\n");
  write("scene.toml", "gravity = \"out/a/frames.csv\"\n" + world(""));
  expect_kept("run scene.toml --out out" + kHours, "out/a/frames.csv");
  write("out/a/energy.html", "0 1\n");
  write("scene.toml", world("probe = [\"file:out/a/energy.html\"]\n"));
  expect_kept("run scene.toml --out out" + kHours, "out/a/energy.html");
  fs::copy(at("free.tremolo"), at("out/a/surface-0000-t0.030000s.ply"));
  write("scene.toml", world("", "a", "out/a/surface-0000-t0.030000s.ply"));
  expect_kept("run scene.toml --out out" + kHours, "out/a/surface-0000-t0.030000s.ply");
  expect_kept("run scene.toml --save out/../scene.toml" + kHours, "scene.toml");
}

TEST_F(KeptInputs, ABodyOfASceneIsKeptFromTheFilesOfAnother) {
  write("out/first/x", "");
  fs::copy(at("bar.tremolo"), at("out/first/frames.csv"));
  write("scene.toml",
        "[first]\nmodel = \"bar.tremolo\"\nduration = 0.03\n[second]\nmodel = "
        "\"out/first/frames.csv\"\nduration = 0.03\n");
  expect_kept("run scene.toml --out out", "out/first/frames.csv");
}

TEST_F(KeptInputs, AFileOfTetrahedraIsNoTableOfTheRun) {
  fs::create_directories(at("out/a"));
  fs::copy(at("bar.tets"), at("out/a/run.csv"));
  write("scene.toml",
        "duration = 0.1\n[[bodies]]\nkind = \"tets\"\nname = \"a\"\nmodel = "
        "\"out/a/run.csv\"\n");
  expect_kept("run scene.toml --out out", "out/a/run.csv");
}

TEST_F(KeptInputs, AConfigOfTheMakerOfTetrahedraIsAnInput) {
  fs::copy(models_ + "/bar.veg", folder_);
  write("bar.toml", "young = 2e6\n");
  const ProgramResult result = run_program(
      folder_, kPrecompute + "tets bar.veg --fix 'x<0.001' --config bar.toml -o bar.toml");
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_EQ(slurp(at("bar.toml")), "young = 2e6\n");
}

TEST_F(KeptInputs, NumberedFilesOfAnExportAreKeptFromInputs) {
  fs::copy(at("bar.tremolo"), at("out-0002.ply"));
  expect_kept("export out-0002.ply --duration 0.1 --series out.ply", "out-0002.ply");
  fs::create_directories(at("x-frames"));
  fs::copy(at("bar.tremolo"), at("x-frames/bar-0000.vtu"));
  expect_kept("export x-frames/bar-0000.vtu --duration 0.1 --pvd x.pvd", "x-frames/bar-0000.vtu");
  // A file of that form that is no input, and that no list names, stays too.
  write("other-0999.ply", "mine");
  ASSERT_EQ(run("export bar.tremolo --duration 0.1 --rate 20 --series other.ply").code, 0);
  EXPECT_EQ(slurp(at("other-0999.ply")), "mine");
}

TEST_F(KeptInputs, APageTakesThePlaceOfNoPageOrReportThatItShows) {
  write("live.html", "the engine");
  expect_kept("export bar.tremolo --duration 0.1 --page live.html --live live.html", "live.html");
  write("pages/live.html", "the engine");
  expect_kept("export bar.tremolo --duration 0.1 --page pages/live.html --live live.html",
              "pages/live.html");
  ASSERT_EQ(run("run bar.tremolo --duration 0.1 --out o").code, 0);
  fs::rename(at("o/report.json"), at("o/report.html"));
  fs::create_symlink("report.html", at("o/report.json"));
  expect_kept("export bar.tremolo --duration 0.1 --page o/report.html --runs o", "o/report.html");
}

TEST_F(KeptInputs, TwoOutputsHaveTwoPlaces) {
  write("scene.toml", world(""));
  expect_refused("run scene.toml --save out/report.json --out out" + kHours, 2, "two outputs");
  expect_refused("export bar.tremolo --vtu a.x --light a.x", 2, "two outputs");
  expect_refused("export bar.tremolo --vtu a.glb --glb ./a.glb" + kHours, 2, "two outputs");
}

TEST_F(KeptInputs, NamesOfBodiesCollideWithNoFileOfTheRun) {
  write("scene.toml", world("", "report.json"));
  expect_refused("run scene.toml --out out" + kHours, 2, "folder");
  write("scene.toml",
        "duration = 1e6\nstep = 0.01\n[[cloths]]\nname = \"run.csv\"\ncolumns = 3\n"
        "rows = 3\n");
  expect_refused("run scene.toml --out out", 2, "folder");
  write("scene.toml",
        "[\"report.json\"]\nmodel = \"bar.tremolo\"\nduration = 1e6\n[other]\nmodel = "
        "\"bar.tremolo\"\n");
  expect_refused("run scene.toml --out out", 2, "folder");
  EXPECT_FALSE(fs::exists(at("out")));
}

TEST_F(KeptInputs, WhatCannotBeWrittenIsKnownBeforeTheFirstStep) {
  write("scene.toml", world(""));
  write("file", "no folder");
  fs::create_directories(at("folder"));
  fs::create_directories(at("folder.wav"));
  for (const std::string flag :
       {"--save nowhere/state", "--save folder", "--save file/state", "--wav nowhere/a.wav",
        "--wav folder.wav", "--out file", "--out file/out"})
    expect_refused("run scene.toml " + flag + kHours, 1, "");
  expect_refused("run bar.tremolo --wav nowhere/a.wav" + kHours, 1, "nowhere/a.wav");
  for (const std::string flag : {"--glb nowhere/a.glb", "--usda nowhere/a.usda",
                                 "--pc2 nowhere/a.pc2", "--mdd nowhere/a.mdd", "--pvd file/a.pvd",
                                 "--series nowhere/a.ply", "--page nowhere/a.html"})
    expect_refused("export bar.tremolo " + flag + kHours, 1, "");
  fs::create_directories(at("out/a/run.csv"));
  expect_refused("run scene.toml --out out" + kHours, 1, "not a regular file");
}

TEST_F(KeptInputs, FoldersOfAnotherScenesBodiesGo) {
  write("first.toml", world("", "a") + "[[bodies]]\nname = \"b\"\nmodel = \"bar.tremolo\"\n");
  write("second.toml", world("", "c"));
  ASSERT_EQ(run("run first.toml --out out --surfaces 2").code, 0);
  EXPECT_TRUE(fs::exists(at("out/a/run.csv")));
  write("out/b/notes.txt", "kept");
  ASSERT_EQ(run("run second.toml --out out").code, 0);
  EXPECT_EQ(names_in("out"), (std::set<std::string>{"report.json", "c/run.csv", "b/notes.txt"}));
  EXPECT_FALSE(fs::exists(at("out/a")));
  // A folder of another run's own stays, though it lies in this one.
  ASSERT_EQ(run("run bar.tremolo --duration 0.03 --out out/c").code, 0);
  ASSERT_EQ(run("run first.toml --out out").code, 0);
  EXPECT_TRUE(fs::exists(at("out/c/run.csv")));
}

TEST_F(KeptInputs, ARunIntoAFolderThatNoRunHadTakesNothingAway) {
  const std::string mine[] = {"energy.svg", "surface-0003.ply", "surface-0001-t0.100000s.ply",
                              "frames.csv", "surface.mtl"};
  for (const std::string folder : {"out/", "out/a/"})
    for (const std::string& name : mine) write(folder + name, "mine");
  write("scene.toml", world(""));
  ASSERT_EQ(run("run scene.toml --out out").code, 0);
  for (const std::string folder : {"out/", "out/a/"})
    for (const std::string& name : mine) EXPECT_EQ(slurp(at(folder + name)), "mine") << name;
}

TEST_F(KeptInputs, ScenesOfSeveralTablesHaveAReportOfAllAndNoStaleFolders) {
  const std::string both = "[a]\nmodel = \"bar.tremolo\"\nduration = 0.03\n";
  write("scene.toml", both + "[b]\nmodel = \"bar.tremolo\"\nduration = 0.03\n");
  ASSERT_EQ(run("run scene.toml --out out").code, 0);
  EXPECT_EQ(json::parse(slurp(at("out/report.json")))["bodies"].size(), 2U);
  ASSERT_EQ(run("run bar.tremolo --duration 0.03 --out out").code, 0);
  EXPECT_EQ(names_in("out"), (std::set<std::string>{"report.json", "run.csv"}));
}

TEST_F(KeptInputs, ASeriesLeavesNothingOfALongerOne) {
  const auto exported = [this](const std::string& duration) {
    const ProgramResult result = run("export bar.tremolo --rate 100 --duration " + duration +
                                     " --series s/out.ply --pvd s/out.pvd");
    ASSERT_EQ(result.code, 0) << result.err;
  };
  fs::create_directories(at("s"));
  exported("0.1");
  const std::size_t longer = names_in("s").size();
  write("s/out-0099.ply", "mine");
  write("s/out-frames/mine-0099.vtu", "mine");
  exported("0.03");
  const std::set<std::string> names = names_in("s");
  EXPECT_LT(names.size(), longer);
  EXPECT_FALSE(names.contains("out-0009.ply"));
  EXPECT_FALSE(names.contains("out-frames/bar-0009.vtu"));
  EXPECT_TRUE(names.contains("out-0002.ply"));
  EXPECT_TRUE(names.contains("out-0099.ply"));
  EXPECT_TRUE(names.contains("out-frames/mine-0099.vtu"));
}

// A process may have fewer open files than the scene has bodies.
TEST_F(KeptInputs, AWorldOfManyBodiesNeedsFewOpenFiles) {
  write("scene.toml", world("copies = [10, 20, 1]\nspacing = [1, 1, 1]\n"));
  const ProgramResult result =
      run_program(folder_, "(ulimit -n 100; " + kTremolo + "run scene.toml --out out --json)");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["bodies"].size(), 200U);
  EXPECT_EQ(names_in("out").size(), 201U);
  EXPECT_EQ(slurp(at("out/a-001/run.csv")).substr(0, 10), "t,kinetic,");
}

// Whatever ends the process from outside: no temporary file stays, of however many.
TEST_F(KeptInputs, NoSignalLeavesTemporaryFiles) {
  write("scene.toml", world("copies = [10, 10, 1]\nspacing = [1, 1, 1]\n"));
  for (const char* signal :
       {"USR1", "USR2", "ALRM", "VTALRM", "PROF", "IO", "ABRT", "RTMIN", "RTMAX"}) {
    const ProgramResult result = run_program(
        folder_, "(" + kTremolo + "run scene.toml --out out" + kHours +
                     "& for i in $(seq 600); do test -e out/a-100/run.csv.partial-* && break; "
                     "sleep 0.05; done; kill -" +
                     signal + " $!; wait $!)");
    EXPECT_GT(result.code, 128) << signal;
    EXPECT_EQ(names_in("out").size(), 0U) << signal;
  }
}

}  // namespace
}  // namespace tremolo
