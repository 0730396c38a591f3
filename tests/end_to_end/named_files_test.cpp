// A file named on a command line may be a pipe, a device or another of the user's files; and the
// programs' output may have nowhere to go.

#include <array>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "common/mesh/surface_mesh.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/surface/surface_writer.h"
#include "tests/support/meshes/surface_files.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

const std::string kModes = " --linear-modes 3 --modes 3 ";

class NamedFiles : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    source_ = fresh_folder();
    testing::write_veg(source_ + "/bar.veg", box_mesh({4, 1, 1}, {0.4, 0.05, 0.06}));
    std::ofstream(source_ + "/ids.txt") << "0 1 2 3\n";
    std::ofstream(source_ + "/bar.toml") << "young = 2e6\n";
    const ProgramResult made =
        run_program(source_, kPrecompute +
                                 "bar.veg -o bar.tremolo --fix 'x<0.001' --load-at "
                                 "'x>0.399' --load-force 0,0,-1" +
                                 kModes);
    ASSERT_EQ(made.code, 0) << made.err;
  }

  void SetUp() override {
    folder_ = fresh_folder();
    for (const char* name : {"bar.veg", "ids.txt", "bar.toml", "bar.tremolo"})
      fs::copy(source_ + "/" + name, folder_);
  }

  // A program that waits for ever is ended. The precompute heeds no other signal before
  // its work begins.
  ProgramResult run(const std::string& command) {
    return run_program(folder_, "timeout -s KILL 30 " + command);
  }

  // The command is refused as wrong usage with `words`, and `file` is as it was.
  void expect_kept(const std::string& command, const std::string& file) {
    const std::string before = slurp(folder_ + "/" + file);
    ASSERT_FALSE(before.empty()) << file;
    const ProgramResult result = run(command);
    EXPECT_EQ(result.code, 2) << command << "\n" << result.err;
    EXPECT_NE(result.err.find("would take the place of"), std::string::npos) << result.err;
    EXPECT_EQ(slurp(folder_ + "/" + file), before) << command;
  }
  // Each command leaves the file next to it unchanged.
  void expect_kept(std::initializer_list<std::pair<std::string, std::string>> commands) {
    for (const auto& [command, file] : commands) expect_kept(command, file);
  }

  static inline std::string source_;
  std::string folder_;
};

TEST_F(NamedFiles, AStandardErrorThatCannotBeWrittenChangesNoResult) {
  for (const std::string silence : {"2>/dev/full", "2>&-"}) {
    const std::string run_it = "(" + kTremolo + "run bar.tremolo --duration 0.1 --out o ";
    EXPECT_EQ(run_program(folder_, run_it + silence + ")").code, 0) << silence;
    EXPECT_TRUE(fs::exists(folder_ + "/o/report.json")) << silence;
    EXPECT_TRUE(slurp(folder_ + "/o/run.csv").starts_with("t,kinetic,")) << silence;
    // No message may end in a file that replaced the closed stream.
    const std::string made = "(" + kPrecompute + "bar.veg -o a.tremolo --fix 'x<0.001'" + kModes;
    EXPECT_EQ(run_program(folder_, made + silence + ")").code, 0) << silence;
    EXPECT_EQ(run("" + kTremolo + "inspect a.tremolo").code, 0) << silence;
    EXPECT_EQ(run_program(folder_, "(" + kTremolo + "run nowhere.tremolo " + silence + ")").code,
              1);
    EXPECT_EQ(run_program(folder_, "(" + kPrecompute + "nowhere.veg -o b " + silence + ")").code,
              1);
    EXPECT_EQ(run_program(folder_, "(" + kMesh + "nowhere.obj -o b " + silence + ")").code, 1);
    fs::remove_all(folder_ + "/o");
  }
}

TEST_F(NamedFiles, AClosedStandardOutputIsAnErrorAndNoFileTakesItsPlace) {
  const ProgramResult result =
      run_program(folder_, "(" + kTremolo + "run bar.tremolo --duration 0.1 --out o --json >&-)");
  EXPECT_EQ(result.code, 1) << result.err;
  EXPECT_TRUE(slurp(folder_ + "/o/run.csv").starts_with("t,kinetic,"));
}

// Else the first file that is opened would get its number, and the words meant for it.
TEST_F(NamedFiles, AClosedStandardErrorIsHeldByEveryProgram) {
  for (const std::string& command :
       {kTremolo + "run bar.tremolo --duration 1e6 --out o",
        kPrecompute + "bar.veg -o a.tremolo --fix 'x<0.001' --linear-modes 20 --modes 60",
        kMesh + "horse -o horse.msh"}) {
    run_program(folder_, "(" + command +
                             " 2>&- & for i in $(seq 2000); do held=$(readlink /proc/$!/fd/2); "
                             "test \"$held\" = /dev/null && break; done; echo $held >held.txt; "
                             "kill -KILL $!; wait)");
    EXPECT_EQ(slurp(folder_ + "/held.txt"), "/dev/null\n") << command;
  }
}

TEST_F(NamedFiles, PipesDevicesAndFoldersAreRefusedAtOnce) {
  ASSERT_EQ(std::system(("mkfifo '" + folder_ + "/pipe' && ln -s pipe '" + folder_ +
                         "/pipe.obj' && ln -s /dev/zero '" + folder_ + "/zero.toml'")
                            .c_str()),
            0);
  const std::string to = " -o new.tremolo";
  for (const std::string& command :
       {kTremolo + "inspect pipe",
        kTremolo + "run pipe",
        kTremolo + "run zero.toml",
        kTremolo + "export pipe --vtu a.vtu",
        kTremolo + "plot pipe -o a.html",
        kTremolo + "plot /dev/zero -o a.html",
        kTremolo + "run bar.tremolo --at file:pipe --force 0,0,1",
        kPrecompute + "pipe" + to,
        kPrecompute + "pipe.obj" + to,
        kPrecompute + "/dev/zero" + to,
        kPrecompute + "bar.veg --fix file:pipe" + to,
        kPrecompute + "bar.veg --fix file:/dev/zero" + to,
        kPrecompute + "bar.veg --config pipe" + to,
        kPrecompute + "bar.veg --config zero.toml" + to,
        kPrecompute + "bar.veg --config ." + to,
        kPrecompute + "bar.veg --render pipe.obj" + to,
        kPrecompute + "bar.veg --import-basis pipe --import-cubic pipe" + to,
        kPrecompute + "reference bar.veg --config=pipe",
        kPrecompute + "reference bar.veg --fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-1 "
                      "--compare pipe",
        kMesh + "pipe.obj -o new.msh"}) {
    const ProgramResult result = run(command + " </dev/null");
    EXPECT_EQ(result.code, 1) << command << "\n" << result.err;
    EXPECT_NE(result.err.find("not a regular file but"), std::string::npos) << result.err;
  }
  EXPECT_FALSE(fs::exists(folder_ + "/new.tremolo"));
}

TEST_F(NamedFiles, NoOutputOfThePrecomputeTakesThePlaceOfAnInput) {
  const std::string make = kPrecompute + "bar.veg --config bar.toml --fix file:ids.txt" + kModes;
  fs::create_symlink("bar.toml", folder_ + "/link.toml");
  fs::create_hard_link(folder_ + "/bar.toml", folder_ + "/hard.toml");
  fs::create_directory(folder_ + "/sub");
  expect_kept({
      {make + "-o bar.toml", "bar.toml"},
      {make + "-o link.toml", "bar.toml"},
      {make + "-o hard.toml", "bar.toml"},
      {make + "-o sub/../bar.toml", "bar.toml"},
      {make + "-o bar.veg", "bar.veg"},
      {make + "-o ids.txt", "ids.txt"},
      {make + "-o a.tremolo --modes-vtu ids.txt", "ids.txt"},
  });
  const std::string lists = kPrecompute + "bar.veg" + kModes + "-o ids.txt --fix 'x<0.001' ";
  expect_kept(lists + "--load-at file:ids.txt --load-force 0,0,1", "ids.txt");
  expect_kept(lists + "--point-mass file:ids.txt=1", "ids.txt");
  expect_kept(lists + "--material 'file:ids.txt: young=1e6'", "ids.txt");
  std::ofstream(folder_ + "/part.txt") << "*MATERIAL m\nENU, 1000, 1e6, 0.3\n";
  const std::string mesh = slurp(folder_ + "/bar.veg");
  std::ofstream(folder_ + "/bar.veg") << mesh << "*INCLUDE part.txt\n";
  expect_kept(make + "-o part.txt", "part.txt");
  fs::copy(folder_ + "/ids.txt", folder_ + "/ids.ply");
  expect_kept(kPrecompute + "bar.veg --fix file:ids.ply -o a.tremolo --preview ids.ply", "ids.ply");
  std::ofstream(folder_ + "/skin.obj") << "mtllib skin.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(folder_ + "/skin.mtl") << "newmtl red\nKd 1 0 0\n";
  expect_kept(make + "--render skin.obj -o a.tremolo --modes-vtu skin.obj", "skin.obj");
  expect_kept(make + "--render skin.obj -o skin.mtl", "skin.mtl");
  std::ofstream(folder_ + "/a.U") << "U";
  std::ofstream(folder_ + "/a.cub") << "cub";
  for (const char* file : {"a.U", "a.cub"})
    expect_kept(
        kPrecompute + "bar.veg --fix 'x<0.001' --import-basis a.U --import-cubic a.cub -o " + file,
        file);
  const ProgramResult twice = run(make + "-o a.tremolo --modes-vtu sub/../a.tremolo");
  EXPECT_EQ(twice.code, 2);
  EXPECT_NE(twice.err.find("two outputs"), std::string::npos) << twice.err;
}

TEST_F(NamedFiles, NoPreviewTakesThePlaceOfAnInputWhereNothingIsComputed) {
  ASSERT_TRUE(write_surface(folder_ + "/box.ply", boundary_mesh(box_mesh({1, 1, 1}, {1, 1, 1}))));
  fs::copy(folder_ + "/ids.txt", folder_ + "/ids.ply");
  expect_kept(kPrecompute + "box.ply --fix none --preview box.ply", "box.ply");
  expect_kept(kPrecompute + "box.ply --select 'x<0.1' --preview box.ply", "box.ply");
  expect_kept(kPrecompute + "bar.veg --fix file:ids.ply --preview ids.ply", "ids.ply");
  expect_kept(kPrecompute + "bar.veg --select file:ids.ply --preview ids.ply", "ids.ply");
  const ProgramResult both = run(kPrecompute + "bar.veg --select 'x<0.1' -o made.tremolo");
  EXPECT_EQ(both.code, 0) << both.err;
  EXPECT_NE(both.err.find("made.tremolo is not written"), std::string::npos) << both.err;
  EXPECT_FALSE(fs::exists(folder_ + "/made.tremolo"));
}

// As nohup starts a program.
// A program that ends before the signal does not fail the test.
TEST_F(NamedFiles, ASignalThatIsIgnoredEndsNothing) {
  testing::write_veg(folder_ + "/larger.veg", box_mesh({8, 5, 5}, {0.4, 0.2, 0.2}));
  for (const std::string& command :
       {kTremolo + "run bar.tremolo --duration 4000 --every 1000",
        kPrecompute + "larger.veg --linear-modes 40 --modes 30 --fix 'x<0.001' -o made.tremolo"}) {
    const ProgramResult result = run_program(
        folder_, "{ trap '' HUP; " + command + " & sleep 0.4; kill -HUP $!; wait $!; }");
    EXPECT_EQ(result.code, 0) << command << "\n" << result.err;
  }
}

TEST_F(NamedFiles, NoOutputOfTheReferenceOrTheMesherTakesThePlaceOfAnInput) {
  fs::create_directory(folder_ + "/o");
  fs::copy(folder_ + "/bar.toml", folder_ + "/o/run.csv");
  expect_kept(kPrecompute + "reference bar.veg --config o/run.csv --fix 'x<0.001' --out o",
              "o/run.csv");
  const std::string move =
      kPrecompute + "reference bar.veg --load-at 'x>0.399' --load-force 0,0,-1 ";
  std::ofstream(folder_ + "/o/run.csv") << "0 1 2 3\n";
  expect_kept(move + "--fix 'x<0.001' --fix-x file:o/run.csv --out o", "o/run.csv");
  expect_kept(move + "--fix 'x<0.001' --probe file:o/run.csv --out o", "o/run.csv");
  fs::copy(folder_ + "/bar.tremolo", folder_ + "/o/run.csv", fs::copy_options::overwrite_existing);
  expect_kept(move + "--fix 'x<0.001' --compare o/run.csv --out o", "o/run.csv");
  std::ofstream(folder_ + "/a.mtl") << "newmtl red\nKd 1 0 0\n";
  std::ofstream(folder_ + "/a.obj") << "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  expect_kept(kMesh + "a.obj -o a.obj", "a.obj");
  expect_kept(kMesh + "a.obj -o a.mtl", "a.mtl");
  expect_kept(kMesh + "a.obj -o a.msh --surface ./a.obj", "a.obj");
}

TEST_F(NamedFiles, NoOutputOfARunTakesThePlaceOfAnInput) {
  fs::create_directory(folder_ + "/o");
  const std::string run_it = kTremolo + "run ";
  fs::copy(folder_ + "/bar.tremolo", folder_ + "/o/run.csv");
  expect_kept(run_it + "o/run.csv --duration 0.1 --out o", "o/run.csv");
  fs::rename(folder_ + "/o/run.csv", folder_ + "/o/surface-0001.ply");
  expect_kept(run_it + "o/surface-0001.ply --duration 0.1 --out ./o", "o/surface-0001.ply");
  fs::copy(folder_ + "/ids.txt", folder_ + "/o/report.json");
  expect_kept(run_it + "bar.tremolo --duration 0.1 --at file:o/report.json --force 0,0,1 --out o",
              "o/report.json");
  std::ofstream(folder_ + "/o/energy.toml") << "[b]\nmodel = '../bar.tremolo'\n";
  fs::create_symlink("energy.toml", folder_ + "/o/energy.html");
  expect_kept(run_it + "o/energy.toml --duration 0.1 --out o --plot", "o/energy.toml");
  for (const char* format : {"--vtu", "--cub", "--U"})
    expect_kept(kTremolo + "export bar.tremolo " + format + " bar.tremolo", "bar.tremolo");
}

TEST_F(NamedFiles, WhatARunReadsBesideItsModelIsKeptToo) {
  fs::create_directory(folder_ + "/o");
  const std::string run_it = kTremolo + "run bar.tremolo --duration 0.1 --out o ";
  std::ofstream(folder_ + "/o/frames.csv") << "0,1\n1,1\n";
  expect_kept(run_it + "--signal o/frames.csv", "o/frames.csv");
  fs::copy(folder_ + "/ids.txt", folder_ + "/o/surface.mtl");
  expect_kept(run_it + "--probe file:o/surface.mtl", "o/surface.mtl");
  expect_kept(run_it + "--start file:o/surface.mtl=0,0,0.01", "o/surface.mtl");
  const std::string record = "--coordinate all --velocities";
  ASSERT_EQ(run(run_it + record).code, 0);
  expect_kept(run_it + record + " --start o/run.csv", "o/run.csv");
  expect_kept(run_it + record + " --start o/run.csv@0.05", "o/run.csv");
  // A picture may be named as a run is.
  fs::copy(folder_ + "/o/run.csv", folder_ + "/run.html");
  expect_kept(kTremolo + "plot run.html -o ./run.html", "run.html");
}

}  // namespace

// tremolo-mesh: a recipe reproduces its mesh.

namespace {

TEST(MeshProgram, MakesTheBeamAnewTheSameEachTime) {
  const std::string folder = fresh_folder();
  const ProgramResult first = run_program(folder, kMesh + "beam -o a.msh --surface a.ply");
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_NE(first.out.find("dihedral angles"), std::string::npos);
  EXPECT_NE(first.out.find("radius ratio"), std::string::npos);
  EXPECT_GT(std::filesystem::file_size(folder + "/a.ply"), 1000u);
  ASSERT_EQ(run_program(folder, kMesh + "beam -o b.msh").code, 0);
  EXPECT_EQ(slurp(folder + "/a.msh"), slurp(folder + "/b.msh"));

  auto made = read_tet_mesh(folder + "/a.msh");
  auto committed = read_tet_mesh(TREMOLO_SOURCE_DIR "/assets/meshes/beam.msh");
  ASSERT_TRUE(made && committed);
  const auto report = check_mesh(made->mesh);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->parts, 1u);
  EXPECT_GE(mesh_quality(made->mesh).min_dihedral_deg, 8.0);
  // Another processor may round a Delaunay predicate's input differently: the same solid, not
  // necessarily the same vertices as the committed one.
  EXPECT_NEAR(report->volume, mesh_quality(committed->mesh).volume, 0.01 * report->volume);
}

TEST(MeshProgram, TheSameSurfaceAsObjAndAsOffGivesTheSameMesh) {
  const std::string folder = fresh_folder();
  const std::array<std::string, 2> star = testing::star_prism();
  std::ofstream(folder + "/star.obj") << star[0];
  std::ofstream(folder + "/star.off") << star[1];
  for (const std::string name : {"obj", "off"}) {
    const ProgramResult made = run_program(folder, kMesh + "star." + name + " -o " + name + ".msh");
    ASSERT_EQ(made.code, 0) << made.err;
  }
  const std::string obj = slurp(folder + "/obj.msh");
  EXPECT_GT(obj.size(), 10'000U);
  EXPECT_EQ(obj, slurp(folder + "/off.msh"));
}

// Its spikes ask for more, and are lost where tetrahedra are larger.
TEST(MeshProgram, ACountThatCannotBeMetGivesTheNearestMesh) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/star.off") << testing::star_prism()[1];
  const ProgramResult made = run_program(folder, kMesh + "star.off -o star.msh --tets 3000");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_TRUE(read_tet_mesh(folder + "/star.msh"));
}

TEST(MeshProgram, WrongUsageIsToldApartAndWritesNothing) {
  const std::string folder = fresh_folder();
  const ProgramResult unknown = run_program(folder, kMesh + "giraffe -o x.msh");
  EXPECT_EQ(unknown.code, 2) << unknown.err;
  EXPECT_NE(unknown.err.find("horse"), std::string::npos) << "the recipes are listed";
  EXPECT_EQ(run_program(folder, kMesh + "beam -o x.msh --size 0.01 --tets 100").code, 2);
  EXPECT_EQ(run_program(folder, kMesh + "beam -o x.msh --size -1").code, 2);
  EXPECT_EQ(run_program(folder, kMesh + "beam").code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder + "/x.msh"));
  EXPECT_EQ(run_program(folder, kMesh + "beam -o no/folder/x.msh").code, 1);
  EXPECT_EQ(run_program(folder, kMesh + "--help").code, 0);
  EXPECT_EQ(run_program(folder, kMesh + "--version").code, 0);
}

}  // namespace
}  // namespace tremolo
