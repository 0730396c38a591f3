// Inputs that tremolo-precompute refuses: exit codes, messages, and outputs that are written whole
// or not at all.
#include <algorithm>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/precompute_folder.h"

namespace tremolo {
namespace {

using PrecomputeRefusals = PrecomputeFolder;

// A mesh that is not there would be exit code 1: it was neither opened nor meshed.
TEST_F(PrecomputeRefusals, WhatNoMeshCouldMakeRightIsRefusedBeforeOneIsLookedFor) {
  const std::string none = "none.obj -o out.tremolo ";
  expect_failure(run(none + "--fix 'x<<1'"), 2, "selector `x<<1`");
  expect_failure(run(none + "--fix none --load-at near:1,2 --load-force 0,0,1"), 2, "near:1,2");
  expect_failure(run(none + "--fix none --load-at near:1,2,3 --load-force 0,0,0"), 3, "zero");
  expect_failure(run("reference none.obj --static --fix 'x<1' --fix-y box:1"), 2, "box:1");
  expect_failure(run(none + "--fix none --point-mass 'sphere:0=1'"), 2, "sphere:0");
  expect_failure(run(none + "--fix none --point-mass 'x<1=-1'"), 3, "positive");
  expect_failure(run("none.obj --select colour:reddish"), 2, "colour:reddish");
  expect_failure(run(none + "--fix none --linear-modes 4 --modes 15"), 3, "give at most 14");
  expect_failure(run(none + "--fix none --modes 0"), 3, "--modes 0");
  expect_failure(run(none + "--fix none --linear-modes 0"), 3, "at least one");
  expect_failure(run(none + "--fix none --linear --modes 21"), 3, "give at most 20");
  expect_failure(run(none + "--fix none --unit ell"), 2, "ell");
  expect_failure(run("reference none.obj --static --fix none --probe plane:1"), 2, "plane:1");
  expect_failure(run(none + "--fix none --linear-modes 4 --modes 14"), 1, "none.obj");
}

// Each drops every direction of the block method: by a mass that hides all others, by overflow and
// by underflow.
TEST_F(PrecomputeRefusals, ModesThatDoublePrecisionDoesNotHoldAreGivenUpWithWords) {
  const std::string modes = " -o out.tremolo --refine 2 --linear-modes 2 --modes 5 --fix 'x<1%'";
  for (const char* extreme : {" --young 1e5 --density 4 --point-mass near:100%,0,0=1e10",
                              " --young 1e-300 --density 1e3", " --young 1e300 --density 1e3",
                              " --young 1e5 --density 1e300", " --young 1e5 --density 1e-300"})
    expect_failure(run("block.veg" + modes + extreme), 4, "check --young, --density, --point-mass");
  expect_failure(run("block.veg -o out.tremolo --refine 2 --linear-modes 2 --modes 5 --fix none "
                     "--young 1e-300 --density 1e3"),
                 4, "check --young");
}

TEST_F(PrecomputeRefusals, TheMeshIsNotOverwritten) {
  const std::string before = slurp(folder_ + "/block.veg");
  const ProgramResult result = run("block.veg -o ./block.veg --fix none");
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_EQ(slurp(folder_ + "/block.veg"), before);
}

TEST_F(PrecomputeRefusals, AConfigFileWithAnUnknownKeyIsRefused) {
  std::ofstream(folder_ + "/config.toml") << "yuong = 1e4\n";
  expect_failure(run(std::string("block.veg --config config.toml ") + kGood), 2, "yuong");
}

TEST_F(PrecomputeRefusals, ANumberSignInQuotesOfAConfigFileIsNoComment) {
  std::ofstream(folder_ + "/config.toml") << "fix = [\"colour:#reddish\"]  # a comment\n";
  expect_failure(run("none.obj --select colour:red --config config.toml"), 2, "colour:#reddish");
}

TEST_F(PrecomputeRefusals, APartThatNothingHoldsIsNamed) {
  TetMesh two = block_;
  testing::join(two, block_, {0, 3, 0});
  expect_failure(run_on(two, "-o out.tremolo --fix 'box:-1,-1,-1,0.01,0.5,1'"), 3, "part 2 of 2");
  const ProgramResult free = run_on(two, "-o free.tremolo --fix none --json");
  ASSERT_EQ(free.code, 0) << free.err;
  EXPECT_EQ(nlohmann::json::parse(free.out)["rigid_modes"], 12);
}

TEST_F(PrecomputeRefusals, APartThatHangsByAVertexOrAnEdgeIsNamed) {
  const TetMesh cube = box_mesh({2, 2, 2}, {0.2, 0.2, 0.2});
  TetMesh corner = cube, edge = cube;
  testing::join(corner, cube, {0.2, 0.2, 0.2});
  testing::join(edge, cube, {0.2, 0.2, 0});
  for (const char* arguments : {kGood, "-o out.tremolo --fix none"}) {
    expect_failure(run_on(corner, arguments), 3, "moves without strain: piece");
    expect_failure(run_on(corner, arguments), 3,
                   "turns on piece 1 about vertex 26 at 0.2, 0.2, 0.2 (a ball joint: 3 motions)");
    expect_failure(run_on(edge, arguments), 3, "(a hinge: 1 motion)");
  }
  // The same joints, with enough fixed vertices behind them.
  const ProgramResult held = run_on(edge, "-o held.tremolo --fix 'x<0.001' --fix 'x>0.399'");
  EXPECT_EQ(held.code, 0) << held.err;
}

// More pieces than are checked: the finding of the modes is reported.
TEST_F(PrecomputeRefusals, ALongChainOfHingesIsRefusedToo) {
  const TetMesh cube = box_mesh({1, 1, 1}, {0.2, 0.2, 0.2});
  // Rounding decides whether a factor of the singular stiffness exists: it differs by direction.
  for (const Eigen::Vector3d& along :
       {Eigen::Vector3d{1, 1, 0}, {1, 0, 1}, {1, -1, 0}, {1, 0, -1}, {1, 1, 1}}) {
    TetMesh chain = cube;
    for (int i = 1; i <= 101; ++i) testing::join(chain, cube, 0.2 * i * along);
    for (const char* fix : {"'x<0.001'", "none"})
      expect_failure(run_on(chain, std::string("-o out.tremolo --linear-modes 4 --fix ") + fix), 3,
                     "moves without strain: it hangs by a vertex or an edge only");
  }
}

// PETSc does not report it by itself.
TEST_F(PrecomputeRefusals, AFactorThatDoesNotFitIsSaidToBeThat) {
  const TetMesh block = box_mesh({14, 10, 10}, {0.3, 0.2, 0.2});
  expect_failure(run_on(block,
                        "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --solver mumps "
                        "-- -mat_mumps_icntl_23 1"),
                 1, "out of memory for the factor of the stiffness (mumps, INFOG(1) = ");
}

TEST_F(PrecomputeRefusals, DerivativesThatDoNotBalanceAreRefused) {
  const TetMesh block = box_mesh({8, 4, 4}, {0.3, 0.15, 0.15});
  expect_failure(run_on(block,
                        "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --solver "
                        "iterative -- -cg_ksp_rtol 1e-3"),
                 4, "residual of the modes");
}

TEST_F(PrecomputeRefusals, OptionsOfMeshingASurfaceAreRefusedForATetrahedralMesh) {
  for (const char* option : {"--tets 3000", "--size 0.1", "--error 0.01", "--thicken 0.01",
                             "--fill-holes", "--keep-crumbs"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
    expect_failure(run(std::string("block.veg ") + option + " " + kGood), 2,
                   name + " applies to meshing a surface: block.veg is tetrahedra already");
  }
}

TEST_F(PrecomputeRefusals, NumbersThatMakeNoSenseAreRefusedInOneLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"--threads 0", "--threads: expected a whole number from 1 to 1024, found 0"},
      {"--threads -2", "--threads: expected a whole number from 1 to 1024, found -2"},
      {"--tets 0", "--tets: expected a whole number from 1"},
      {"--size 0", "--size: expected a number above 0, found 0"},
      {"--error nan", "--error: expected a number above 0, found nan"},
      {"--memory -5",
       "--memory: expected a whole number of bytes above 0, as 4GB or 500MB, found -5"},
      {"--memory 0", "found 0"},
      {"--memory much", "found much"},
      {"--load-at 'x>0.3' --load-force 0 0 -5",
       "--load-force takes one word, X,Y,Z with commas: --load-force 0,0,-5"},
      {"--load-at 'x>0.3' --load-force 0, 0, -5", "--load-force 0,0,-5"}};
  for (const auto& [option, words] : cases) {
    const ProgramResult result =
        run(std::string("block.veg ") + option + " -o out.tremolo --fix 'x<0.001'");
    expect_failure(result, 2, words);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_LE(result.err.size(), 160u) << result.err;
  }
}

TEST_F(PrecomputeRefusals, MemoryThatWillNotDoIsToldInWholeSentences) {
  const ProgramResult result = run(std::string("block.veg --memory 1kb ") + kGood);
  expect_failure(result, 1,
                 "but 1e-06 GB are allowed by --memory. Take more ranks on more machines");
}

// Whatever the limit is, it ends: with the file, or with a message that says so. Below 200 MB the
// system cannot load the program's libraries, and says that itself.
TEST_F(PrecomputeRefusals, UnderALimitOfAddressSpaceItEndsInWords) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take the address space for themselves";
#endif
  const TetMesh block = box_mesh({14, 8, 8}, {0.3, 0.2, 0.2});
  write_veg(folder_ + "/larger.veg", block);
#ifdef TREMOLO_LONG_TESTS
  constexpr int kFine = 20'000;
#else
  constexpr int kFine = 150'000;
#endif
  int refused = 0;
  for (int limit = 200'000; limit < 2'400'000; limit += limit < 1'000'000 ? kFine : 400'000) {
    const ProgramResult result = run_program(
        folder_, "ulimit -v " + std::to_string(limit) +
                     "; OPENBLAS_NUM_THREADS=2 timeout -s KILL "
                     "60 " +
                     kPrecompute + "larger.veg --threads 2 -o limited.tremolo --fix 'x<0.001'");
    if (result.code == 0) {
      std::filesystem::remove(folder_ + "/limited.tremolo");
      continue;
    }
    // The loader of shared libraries has no room: the program has not begun.
    if (result.code == 127 && result.err.find("shared object") != std::string::npos) continue;
    ++refused;
    EXPECT_EQ(result.code, 1) << limit << ": " << result.err;
    EXPECT_NE(result.err.find("out of memory"), std::string::npos) << limit << ": " << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ + "/limited.tremolo")) << limit;
  }
  EXPECT_GE(refused, 4) << "the limits are no limits here";
  const ProgramResult result = run_program(
      folder_, "ulimit -v 400000; OPENBLAS_NUM_THREADS=2 " + kPrecompute + "block.veg " + kGood);
  expect_failure(result, 1,
                 "MB of address space would do for the start, the limit (ulimit -v) is 410 MB");
  expect_failure(result, 1, "with OPENBLAS_NUM_THREADS=1 and --threads 1 it is ");
}

TEST_F(PrecomputeRefusals, MoreFreePartsThanCanBeTakenAreRefusedAtOnce) {
  const TetMesh cube = box_mesh({1, 1, 1}, {0.1, 0.1, 0.1});
  TetMesh many;
  for (int i = 0; i < 1001; ++i) testing::add_apart(many, cube, {0.3 * i, 0, 0});
  expect_failure(run_on(many, "-o out.tremolo --fix none"), 3,
                 "a free body of 1001 parts that do not touch");
}

TEST_F(PrecomputeRefusals, AHoldThatIsNotEnoughSaysWhatIsLeft) {
  expect_failure(run("block.veg -o out.tremolo --fix vertex:0,1,2"), 3,
                 "1 rigid motion is left (rotation about the line through vertex");
  expect_failure(run("block.veg -o out.tremolo --fix vertex:3"), 3,
                 "rotations about vertex 3 at 0.3, 0, 0, the only fixed one");
}

TEST_F(PrecomputeRefusals, BadMeshesAreRefusedWithoutTouchingTheOutput) {
  expect_failure(run(std::string("missing.veg ") + kGood), 1, "missing.veg");
  std::ofstream(folder_ + "/empty.msh").flush();
  expect_failure(run(std::string("empty.msh ") + kGood), 3, "empty.msh");
  std::ofstream(folder_ + "/noise.msh") << std::string(3000, 'q');
  expect_failure(run(std::string("noise.msh ") + kGood), 3, "noise.msh");
  const std::string text = slurp(folder_ + "/block.veg");
  std::ofstream(folder_ + "/cut.veg") << text.substr(0, text.size() / 2);
  expect_failure(run(std::string("cut.veg ") + kGood), 3, "cut.veg");

  TetMesh changed = block_;
  changed.vertices[7].y() = std::nan("");
  expect_failure(run_on(changed), 3, "changed.veg");
  changed = block_;
  changed.vertices[7].z() = INFINITY;
  expect_failure(run_on(changed), 3, "changed.veg");
  changed = block_;
  changed.tetrahedra[3][2] = 12345;
  expect_failure(run_on(changed), 3, "12346");  // .veg counts from 1
  changed = block_;
  changed.tetrahedra[3][2] = changed.tetrahedra[3][1];
  expect_failure(run_on(changed), 3, "tetrahedron");
  changed = block_;
  changed.tetrahedra.push_back(changed.tetrahedra[5]);
  expect_failure(run_on(changed), 3, "same");
}

TEST_F(PrecomputeRefusals, RepairsAndOdditiesAreReported) {
  TetMesh changed = block_;
  std::swap(changed.tetrahedra[3][0], changed.tetrahedra[3][1]);
  changed.vertices.emplace_back(9, 9, 9);
  const ProgramResult result = run_on(changed, "-o odd.tremolo --fix 'x<0.001'");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("repaired"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("no tetrahedron"), std::string::npos) << result.err;
  const auto data = read_basis(folder_ + "/odd.tremolo");
  ASSERT_TRUE(data);
  EXPECT_EQ(data->vertex_count, block_.vertices.size() + 1 + data->edges.size());
}

TEST_F(PrecomputeRefusals, ImpossibleMaterialsAreRefused) {
  for (const char* bad :
       {"--poisson 0.5", "--poisson 0.7", "--poisson=-1", "--poisson nan", "--young 0",
        "--young=-5", "--young inf", "--density 0", "--density=-1", "--density nan"})
    expect_failure(run(std::string("block.veg ") + bad + " " + kGood), 3, "must be");
}

TEST_F(PrecomputeRefusals, ImpossibleConstraintsAndCountsAreRefused) {
  expect_failure(run("block.veg -o out.tremolo --fix 'x>-1'"), 3, "every vertex");
  expect_failure(run("block.veg -o out.tremolo"), 3, "--fix");
  expect_failure(run("block.veg -o out.tremolo --fix vertex:3"), 3, "is not held");
  expect_failure(run("block.veg -o out.tremolo --fix 'x<-7'"), 3, "0.4");  // the bounding box
  expect_failure(run("block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 1000"), 3,
                 "--linear-modes 1000");
  expect_failure(run("block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 0"), 3, "");
  expect_failure(run("block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 3 --modes 10"), 3,
                 "--modes 10");
  expect_failure(run(std::string("block.veg --load-at 'x<0.001' --load-force 0,0,1 ") + kGood), 3,
                 "fixed");
  expect_failure(run(std::string("block.veg --load-at near:-0.1,0,0 --load-force 0,0,1 ") + kGood),
                 3, "is fixed; near:-0.1,0,0: vertex ");
  expect_failure(run(std::string("block.veg --load-at near:-0.1,0,0 --load-force 0,0,1 ") + kGood),
                 3, "m across: if its unit is not 1 m");
  expect_failure(run(std::string("block.veg --load-at 'x>0.39' ") + kGood), 3, "--load-force");
}

TEST_F(PrecomputeRefusals, WrongUsageIsToldApart) {
  expect_failure(run(std::string("block.veg --no-such-flag ") + kGood), 2, "no-such-flag");
  expect_failure(run("-o out.tremolo"), 2, "mesh");
  expect_failure(run("block.veg -o out.tremolo --fix 'x<<1'"), 2, "x<<1");
  expect_failure(run(std::string("block.veg --load-at 'x>0.39' --load-force 1,2 ") + kGood), 2,
                 "--load-force");
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_EQ(run("--version").code, 0);
}

TEST_F(PrecomputeRefusals, AnUnwritableOutputIsASystemError) {
  const std::string rest = " --fix 'x<0.001' --linear-modes 4 --modes 8";
  expect_failure(run("block.veg -o no/such/folder/x.tremolo" + rest), 1, "no/such/folder");
  expect_failure(run("block.veg -o /dev/full" + rest), 1, "/dev/full");
  expect_failure(run("block.veg -o ." + rest), 1, "regular file");
}

TEST_F(PrecomputeRefusals, CtrlCAndTermLeaveTheOldOutputAlone) {
  write_veg(folder_ + "/large.veg", box_mesh({60, 12, 12}, {1.2, 0.2, 0.2}));
  for (const auto& [name, code] : {std::pair{"INT", 130}, {"TERM", 143}, {"KILL", 137}})
    for (const char* delay : {"0.05", "0.4"}) {
      const ProgramResult result =
          run_program(folder_, std::string("timeout --preserve-status -s ") + name + " " + delay +
                                   " " + kPrecompute + "large.veg -o out.tremolo --fix 'x<0.001'");
      EXPECT_EQ(result.code, code) << name << " " << delay << "\n" << result.err;
      EXPECT_EQ(slurp(folder_ + "/out.tremolo"), kOld);
    }
}

}  // namespace
}  // namespace tremolo
