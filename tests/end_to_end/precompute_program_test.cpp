// tremolo-precompute as a user meets it: exit codes, messages, and outputs that appear whole or not
// at all.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh/edge_points.h"
#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

const std::string kOld = "an older file that must survive";

// A folder with block.veg and an existing out.tremolo.
class PrecomputeProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", block_);
    std::ofstream(folder_ + "/out.tremolo") << kOld;
  }

  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kPrecompute + arguments);
  }

  // What a run that succeeds says as JSON.
  nlohmann::json told(const std::string& arguments) {
    const ProgramResult result = run(arguments + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }

  // Writes a changed block and runs on it.
  ProgramResult run_on(const TetMesh& mesh, const std::string& arguments = kGood) {
    write_veg(folder_ + "/changed.veg", mesh);
    return run("changed.veg " + arguments);
  }

  void expect_failure(const ProgramResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(slurp(folder_ + "/out.tremolo"), kOld) << "the old output was touched";
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
  }

  static constexpr const char* kGood =
      "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --threads 1";
  const std::string kBlock = std::string("block.veg ") + kGood;
  TetMesh block_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
  std::string folder_;
};

TEST_F(PrecomputeProgram, ACompactFileTellsItsErrorsOnStderrInJsonAndInItself) {
  const ProgramResult result = run(std::string("block.veg --encoding compact --json ") + kGood);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("compact: displacement off by"), std::string::npos) << result.err;
  const auto encoding = nlohmann::json::parse(result.out)["encoding"];
  EXPECT_EQ(encoding["name"], "compact");
  // A tenth of the size times 8 coordinates times 2.6e-5 each.
  EXPECT_LE(encoding["displacement_error_bound"], 2.1e-5);
  EXPECT_LE(encoding["displacement_error"], encoding["displacement_error_bound"]);
  EXPECT_GT(encoding["displacement_error"], 0.0);
  EXPECT_GT(encoding["force_error"], 0.0);
  EXPECT_LE(encoding["force_error"], 1e-4);
  const auto compact = read_basis(folder_ + "/out.tremolo");
  ASSERT_TRUE(compact) << compact.error().message;
  EXPECT_EQ(nlohmann::json::parse(compact->provenance)["encoding"], encoding);
  ASSERT_EQ(run(std::string("block.veg ") + kGood).code, 0);
  const auto full = read_basis(folder_ + "/out.tremolo");
  ASSERT_TRUE(full);
  EXPECT_FALSE(nlohmann::json::parse(full->provenance).contains("encoding"));
  EXPECT_EQ(compact->lambda, full->lambda);
  EXPECT_TRUE(compact->surface.rows.isApprox(full->surface.rows, 1e-4));
}

TEST_F(PrecomputeProgram, ALinearModelKeepsEveryLinearModeAskedForAndTellsACut) {
  const std::string linear = "block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 40 --linear";
  const ProgramResult all = run(linear + " --json");
  ASSERT_EQ(all.code, 0) << all.err;
  const auto report = nlohmann::json::parse(all.out);
  EXPECT_EQ(report["r"], 40);
  EXPECT_EQ(report["frequencies_hz"].size(), 40u);
  EXPECT_EQ(all.err.find("of the 40 linear modes"), std::string::npos) << all.err;
  const ProgramResult cut = run(linear + " --modes 30 --json");
  ASSERT_EQ(cut.code, 0) << cut.err;
  const std::string note = "of the 40 linear modes the basis keeps 30";
  EXPECT_NE(cut.err.find(note), std::string::npos) << cut.err;
  const auto less = nlohmann::json::parse(cut.out);
  EXPECT_EQ(less["r"], 30);
  EXPECT_NE(less["notes"].dump().find(note), std::string::npos) << less["notes"];
}

// A mesh that is not there would be exit code 1: nobody has looked for it, nor meshed it.
TEST_F(PrecomputeProgram, WhatNoMeshCouldMakeRightIsRefusedBeforeOneIsLookedFor) {
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

TEST_F(PrecomputeProgram, NearTellsWhichVertexItTookAndHowFarAway) {
  const std::string load = " --load-force 0,0,-1 --load-at ";
  const ProgramResult one = run(kBlock + load + "near:0.4,0.16,0.2");
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_NE(one.err.find("--load-at near:0.4,0.16,0.2: vertex 44 at (0.4, 0.15, 0.2) m, 0.01 m"),
            std::string::npos)
      << one.err;
  const ProgramResult held =
      run("block.veg -o held.tremolo --fix 'x<0.001' --fix near:0,0.01,0 --point-mass "
          "near:0.4,0.16,0.2=1 --linear-modes 4 --modes 8");
  ASSERT_EQ(held.code, 0) << held.err;
  EXPECT_NE(held.err.find("--fix near:0,0.01,0: vertex 0 at (0, 0, 0) m, 0.01 m"),
            std::string::npos)
      << held.err;
  EXPECT_NE(held.err.find("--point-mass near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << held.err;
  const ProgramResult along =
      run("reference block.veg --static --fix 'x<0.001' --fix-y near:0.4,0.16,0.2 --load-at "
          "'x>0.399' --load-force 0,0,-1");
  EXPECT_NE(along.err.find("--fix-y near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << along.err;
  const ProgramResult select = run("block.veg --select near:0.4,0.15,0.2,2");
  EXPECT_NE(select.err.find("2 vertices, the nearest vertex 44"), std::string::npos) << select.err;
  const ProgramResult moved =
      run_program(folder_, TREMOLO_BIN_DIR
                  "/tremolo run out.tremolo --duration 0.01 --load constant --out moved --at "
                  "near:0.4,0.16,0.2 --force 0,0,1");
  EXPECT_EQ(moved.code, 0) << moved.err;
  EXPECT_NE(moved.err.find("--at near:0.4,0.16,0.2: vertex 44 at"), std::string::npos) << moved.err;
  const ProgramResult probed =
      run_program(folder_, TREMOLO_BIN_DIR
                  "/tremolo run out.tremolo --duration 0.01 --load none --probe near:0.4,0.16,0.2");
  EXPECT_NE(probed.err.find("--probe near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << probed.err;
  const ProgramResult inspected = run_program(
      folder_, TREMOLO_BIN_DIR "/tremolo inspect out.tremolo --select near:0.4,0.16,0.2");
  EXPECT_NE(inspected.err.find("near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << inspected.err;
}

TEST_F(PrecomputeProgram, UpYTurnsTheModelAndItsSelectors) {
  const std::string options = " --linear-modes 4 --modes 8 --threads 1 --json";
  const ProgramResult plain =
      run("block.veg -o plain.tremolo --fix 'y<0.001' --load-at 'y>0.149' --load-force 0,-1,0" +
          options);
  const ProgramResult turned = run(
      "block.veg -o turned.tremolo --up y --fix 'z<0.001' --load-at 'z>0.149' --load-force 0,0,-1" +
      options);
  ASSERT_EQ(plain.code, 0) << plain.err;
  ASSERT_EQ(turned.code, 0) << turned.err;
  const auto frequencies = nlohmann::json::parse(plain.out)["frequencies_hz"];
  const auto again = nlohmann::json::parse(turned.out)["frequencies_hz"];
  for (std::size_t i = 0; i < frequencies.size(); ++i)
    EXPECT_NEAR(again[i], double(frequencies[i]), 1e-6 * double(frequencies[i]));
  const auto a = read_basis(folder_ + "/plain.tremolo"),
             b = read_basis(folder_ + "/turned.tremolo");
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->surface.rest.size(), b->surface.rest.size());
  for (std::size_t v = 0; v < a->surface.rest.size(); ++v) {
    const Eigen::Vector3d& x = a->surface.rest[v];
    EXPECT_EQ(b->surface.rest[v], Eigen::Vector3d(x[0], -x[2], x[1]));
  }
  expect_failure(run(kBlock + " --up x"), 2, "--up");
}

// What is drawn lies where the solid is.
TEST_F(PrecomputeProgram, UpYTurnsWhatIsDrawnToo) {
  std::ofstream obj(folder_ + "/box.obj");
  for (const double x : {0.0, 0.4})
    for (const double y : {0.0, 0.15})
      for (const double z : {0.0, 0.2}) obj << "v " << x << ' ' << y << ' ' << z << '\n';
  obj << "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
  obj.close();
  for (const std::string solid : {"box.obj --size 0.1", "block.veg --render box.obj"}) {
    const ProgramResult made = run(solid +
                                   " -o up.tremolo --up y --fix 'z<0.001' --linear-modes 4 "
                                   "--modes 8");
    ASSERT_EQ(made.code, 0) << made.err;
    const auto basis = read_basis(folder_ + "/up.tremolo");
    ASSERT_TRUE(basis);
    ASSERT_TRUE(basis->render);
    const BoundingBox drawn = bounding_box(basis->render->surface.vertices);
    EXPECT_LE((drawn.low - Eigen::Vector3d(0, -0.2, 0)).norm(), 1e-6) << solid;
    EXPECT_LE((drawn.high - Eigen::Vector3d(0.4, 0, 0.15)).norm(), 1e-6) << solid;
  }
}

// It stands on its square end along y and comes to a ridge above.
TEST_F(PrecomputeProgram, WhoHoldsTheSideOfWhatStandsOnYIsTold) {
  TetMesh standing = box_mesh({4, 4, 4}, {1, 1, 1});
  for (Eigen::Vector3d& x : standing.vertices)
    for (const int other : {0, 2}) x[other] = 0.5 + (1 - 0.9 * x[1]) * (x[other] - 0.5);
  const std::string hint = "z<30% takes the body's side, if y points up";
  const std::string modes = " --linear-modes 4 --modes 8 -o side.tremolo";
  const ProgramResult side = run_on(standing, "--fix 'z<30%'" + modes);
  EXPECT_EQ(side.code, 0) << side.err;
  EXPECT_NE(side.err.find(hint), std::string::npos) << side.err;
  EXPECT_NE(run_on(standing, "--select 'z<30%'").err.find(hint), std::string::npos);
  // Where the side does not hold the body, too: here it is an edge, about which it can turn.
  const ProgramResult edge = run_on(standing, "--fix 'z<1%'" + modes);
  EXPECT_EQ(edge.code, 3) << edge.err;
  EXPECT_NE(edge.err.find("z<1% takes the body's side, if y points up"), std::string::npos)
      << edge.err;
  const ProgramResult turned = run_on(standing, "--up y --fix 'z<30%'" + modes);
  EXPECT_EQ(turned.code, 0) << turned.err;
  EXPECT_EQ(turned.err.find("takes the body's side"), std::string::npos) << turned.err;
}

TEST_F(PrecomputeProgram, PreviewPaintsWhatIsHeldAndLoadedAndComputesNothing) {
  const ProgramResult alone =
      run("block.veg --fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-5 --preview look.ply");
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(alone.err.find("look.ply: 9 vertices held, 9 loaded"), std::string::npos) << alone.err;
  EXPECT_EQ(slurp(folder_ + "/out.tremolo"), kOld);
  const std::string ply = slurp(folder_ + "/look.ply");
  EXPECT_NE(ply.find("property uchar red"), std::string::npos);
  // The hull's 42 vertices, the arrow's 50: floats and colour.
  const std::size_t data = ply.find("end_header\n") + 11;
  ASSERT_GT(ply.size(), data + 92 * 15);
  EXPECT_NE(ply.find("element vertex 92\n"), std::string::npos);
  std::map<std::string, int> count;
  for (std::size_t v = 0; v < 92; ++v) ++count[ply.substr(data + 15 * v + 12, 3)];
  EXPECT_EQ(count[std::string("\x28\x5a\xdc")], 9) << "blue";
  EXPECT_EQ(count[std::string("\xdc\x28\x1e")], 9 + 50) << "red, with the arrow";
  EXPECT_EQ(count[std::string("\xc8\xc8\xc8")], 24) << "grey";
  // The arrow's tail and tip come last: it points down, at or from the middle of what is loaded.
  float tail[3], tip[3];
  std::memcpy(tail, ply.data() + data + 15 * 90, sizeof(tail));
  std::memcpy(tip, ply.data() + data + 15 * 91, sizeof(tip));
  for (const float* end : {tail, tip}) {
    EXPECT_NEAR(end[0], 0.4, 1e-6);
    EXPECT_NEAR(end[1], 0.075, 1e-6);
  }
  EXPECT_NEAR(tail[2] - tip[2], 0.25 * std::hypot(0.4, 0.15, 0.2), 1e-6);
  EXPECT_NEAR(std::min(std::abs(tail[2] - 0.1), std::abs(tip[2] - 0.1)), 0, 1e-6);

  ASSERT_EQ(run("block.veg --select 'y<0.001' --preview chosen.ply").code, 0);
  EXPECT_NE(slurp(folder_ + "/chosen.ply").find(std::string("\x28\xaa\x3c")), std::string::npos);
  expect_failure(run("block.veg --fix none --preview look.obj"), 2, "look.obj");
  expect_failure(run(kBlock + " --preview block.veg"), 2, "block.veg");

  // Beside a model, which stays the same byte for byte.
  ASSERT_EQ(run("block.veg -o a.tremolo --fix 'x<0.001' --preview a.ply").code, 0);
  ASSERT_EQ(run("block.veg -o b.tremolo --fix 'x<0.001'").code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/a.ply"));
  EXPECT_EQ(slurp(folder_ + "/a.tremolo"), slurp(folder_ + "/b.tremolo"));
}

TEST_F(PrecomputeProgram, NearFromAnotherWorldIsRefused) {
  for (const std::string point : {"1e30,0,0", "400,150,200", "0,0,1e200"})
    expect_failure(run(kBlock + " --load-force 0,0,-1 --load-at near:" + point), 3,
                   "m away from the nearest vertex");
  EXPECT_EQ(run("block.veg --select near:1,1,1").code, 0) << "outside, but not far";
}

TEST_F(PrecomputeProgram, ALinearModelIsItsLinearModesAlone) {
  const std::string linear = "block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 4 --linear";
  const nlohmann::json report = told(linear);
  EXPECT_EQ(report["r"], 4);
  for (const auto& stage : report["stages"]) {
    EXPECT_NE(stage["name"], "derivatives");
    EXPECT_NE(stage["name"], "coefficients");
  }
  const auto data = read_basis(folder_ + "/out.tremolo");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_TRUE(data->cubic.empty());
  EXPECT_TRUE(data->quartic.empty());
  const ProgramResult more = run(linear + " --modes 5");
  EXPECT_EQ(more.code, 3) << "there are four modes";
}

TEST_F(PrecomputeProgram, MakesABasisFileAndSaysWhatCameOut) {
  const ProgramResult result = run(std::string("block.veg --json ") + kGood);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("frequencies"), std::string::npos);
  EXPECT_NE(result.err.find("explicit methods are stable below a step of"), std::string::npos);
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["order"], 2);
  EXPECT_EQ(report["n"], block_.vertices.size() + mesh_edges(block_).size());
  EXPECT_EQ(report["m"], block_.tetrahedra.size());
  EXPECT_EQ(report["r"], 8);
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
  EXPECT_LE(report["polynomial_error"], 1e-12);
  for (double residual : report["mode_residuals"]) EXPECT_LE(residual, 1e-8);
  EXPECT_EQ(report["cut_singular_values"].size(), 4 + 10 + 4 - 8);
  for (const auto& stage : report["stages"]) {
    EXPECT_GE(stage["seconds"], 0);
    EXPECT_GT(stage["peak_bytes"], 0);
  }
  const auto data = read_basis(folder_ + "/out.tremolo");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->lambda.size(), 8);
  EXPECT_EQ(data->surface.vertex_ids.size() + data->interior.vertex_ids.size(), report["n"]);
}

TEST_F(PrecomputeProgram, TheSameMeshGivesTheSameBytes) {
  ASSERT_EQ(run("block.veg -o a.tremolo --fix 'x<0.001'").code, 0);
  ASSERT_EQ(run("block.veg -o b.tremolo --fix 'x<0.001' --threads 3 --json").code, 0);
  const std::string a = slurp(folder_ + "/a.tremolo");
  EXPECT_FALSE(a.empty());
  EXPECT_EQ(a, slurp(folder_ + "/b.tremolo"));
}

TEST_F(PrecomputeProgram, FrequenciesScaleWithDensitySizeAndStiffness) {
  const auto frequencies = [&](const std::string& mesh, const std::string& options) {
    const ProgramResult result =
        run(mesh + " -o scaled.tremolo --linear-modes 5 --modes 12 --json " + options);
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out)["frequencies_hz"].get<std::vector<double>>();
  };
  TetMesh large = block_;
  for (Eigen::Vector3d& x : large.vertices) x *= 1000.0;
  write_veg(folder_ + "/large.veg", large);
  const auto f = frequencies("block.veg", "--fix 'x<0.001'");
  const auto heavy = frequencies("block.veg", "--fix 'x<0.001' --density 1e9");
  const auto stiff = frequencies("block.veg", "--fix 'x<0.001' --young 1e10");
  const auto big = frequencies("large.veg", "--fix 'x<1'");
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(heavy[i], f[i] / 1e3, 1e-8 * f[i] / 1e3);  // the eigenvectors' rounding
    EXPECT_NEAR(stiff[i], f[i] * 1e2, 1e-8 * f[i] * 1e2);
    EXPECT_NEAR(big[i], f[i] / 1e3, 1e-8 * f[i] / 1e3);
  }
}

TEST_F(PrecomputeProgram, TheBasisKeepsTheLowestModes) {
  ASSERT_EQ(run("block.veg -o many.tremolo --fix 'x<0.001' --linear-modes 8 --modes 16").code, 0);
  ASSERT_EQ(run("block.veg -o one.tremolo --fix 'x<0.001' --linear-modes 1 --modes 1").code, 0);
  const auto many = read_basis(folder_ + "/many.tremolo");
  const auto one = read_basis(folder_ + "/one.tremolo");
  ASSERT_TRUE(many && one);
  // The single direction of the PCA leans a little towards the derivative of the mode.
  EXPECT_NEAR(one->lambda[0], many->lambda[0], 0.02 * many->lambda[0]);
}

TEST_F(PrecomputeProgram, TheMeshIsNotOverwritten) {
  const std::string before = slurp(folder_ + "/block.veg");
  const ProgramResult result = run("block.veg -o ./block.veg --fix none");
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_EQ(slurp(folder_ + "/block.veg"), before);
}

TEST_F(PrecomputeProgram, AThinFreePlateIsComputedToo) {
  write_veg(folder_ + "/plate.veg", box_mesh({16, 16, 1}, {1.0, 1.0, 0.001}));
  const ProgramResult result = run("plate.veg -o plate.tremolo --fix none --linear-modes 6 --json");
  EXPECT_EQ(result.code, 0) << result.err;
}

TEST_F(PrecomputeProgram, AConfigFileWithAnUnknownKeyIsRefused) {
  std::ofstream(folder_ + "/config.toml") << "yuong = 1e4\n";
  expect_failure(run(std::string("block.veg --config config.toml ") + kGood), 2, "yuong");
}

TEST_F(PrecomputeProgram, LumpedMassIsAnOptionThroughout) {
  ASSERT_EQ(run("block.veg -o a.tremolo --fix 'x<0.001' --mass lumped --json").code, 0);
  const auto report = nlohmann::json::parse(slurp(folder_ + "/stdout.txt"));
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
  expect_failure(run(std::string("block.veg --mass wrong ") + kGood), 2, "--mass");
}

TEST_F(PrecomputeProgram, PassesPetscOptionsOnAndWarnsOfThoseNobodyReads) {
  const ProgramResult result = run(std::string("block.veg --json ") + kGood +
                                   " -- -st_pc_factor_mat_solver_type mumps -pc_type lu");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["factorisation"], "mumps");
  EXPECT_NE(result.err.find("-pc_type (a typo?)"), std::string::npos) << result.err;
}

TEST_F(PrecomputeProgram, SeveralRanksFindTheSameModel) {
  ASSERT_EQ(run(std::string("block.veg --json ") + kGood).code, 0);
  const auto one = nlohmann::json::parse(slurp(folder_ + "/stdout.txt"));
  const ProgramResult result = run_program(folder_, kMayBeRoot + "mpiexec --oversubscribe -n 2 " +
                                                        kPrecompute + "block.veg --json " + kGood);
  ASSERT_EQ(result.code, 0) << result.err;
  const auto two = nlohmann::json::parse(result.out);
  EXPECT_EQ(two["factorisation"], "mumps");
  for (std::size_t i = 0; i < 8; ++i) {
    const double f = one["frequencies_hz"][i];
    EXPECT_NEAR(two["frequencies_hz"][i], f, 1e-9 * f);  // another factorisation's rounding
  }
  EXPECT_LE(two["polynomial_error"], 1e-12);
}

// What is not made there cannot be fought over by several runs at once.
TEST_F(PrecomputeProgram, OneRankNeedsNoTemporaryFolder) {
  const ProgramResult result =
      run_program(folder_, "TMPDIR=/no/such/folder " + kPrecompute + "block.veg " + kGood);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err.find("mkdir"), std::string::npos) << result.err;
}

TEST_F(PrecomputeProgram, AFreeBodyLeavesItsRigidMotionOut) {
  const ProgramResult result = run("block.veg -o free.tremolo --fix none --json --modes 8");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["rigid_modes"], 6);
  EXPECT_TRUE(report["certified_by_inertia"]);
  EXPECT_NE(result.err.find("6 rigid motions are left out"), std::string::npos);
  const auto data = read_basis(folder_ + "/free.tremolo");
  ASSERT_TRUE(data);
  EXPECT_EQ(data->rigid_mode_count, 6u);
  EXPECT_EQ(data->fixed_vertex_count, 0u);
}

TEST_F(PrecomputeProgram, APartThatNothingHoldsIsNamed) {
  TetMesh two = block_;
  testing::join(two, block_, {0, 3, 0});
  expect_failure(run_on(two, "-o out.tremolo --fix 'box:-1,-1,-1,0.01,0.5,1'"), 3, "part 2 of 2");
  const ProgramResult free = run_on(two, "-o free.tremolo --fix none --json");
  ASSERT_EQ(free.code, 0) << free.err;
  EXPECT_EQ(nlohmann::json::parse(free.out)["rigid_modes"], 12);
}

TEST_F(PrecomputeProgram, APartThatHangsByAVertexOrAnEdgeIsNamed) {
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
  // The same joints, with enough held behind them.
  const ProgramResult held = run_on(edge, "-o held.tremolo --fix 'x<0.001' --fix 'x>0.399'");
  EXPECT_EQ(held.code, 0) << held.err;
}

// More pieces than are looked at: what the modes show is told.
TEST_F(PrecomputeProgram, ALongChainOfHingesIsRefusedToo) {
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

// OpenBLAS may be older than the processor.
TEST_F(PrecomputeProgram, DenseProductsUseTheProcessorsVectors) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "it has no AVX2";
  const ProgramResult result =
      run_program(folder_, "env -u OPENBLAS_CORETYPE OPENBLAS_VERBOSE=2 " TREMOLO_BIN_DIR
                           "/tremolo-precompute block.veg " +
                               std::string(kGood));
  ASSERT_EQ(result.code, 0) << result.err;
  const std::size_t at = result.err.rfind("Core: ");
  ASSERT_NE(at, std::string::npos) << result.err;
  const std::string core = result.err.substr(at + 6, result.err.find('\n', at) - at - 6);
  for (const char* slow : {"Prescott", "Nehalem", "Sandybridge"}) EXPECT_NE(core, slow);
  // What a user asks for stays.
  const ProgramResult asked =
      run_program(folder_, "env OPENBLAS_CORETYPE=Prescott OPENBLAS_VERBOSE=2 " TREMOLO_BIN_DIR
                           "/tremolo-precompute block.veg " +
                               std::string(kGood));
  EXPECT_NE(asked.err.find("Core: Prescott"), std::string::npos) << asked.err;
#endif
}

// PETSc does not tell by itself.
TEST_F(PrecomputeProgram, AFactorThatDoesNotFitIsSaidToBeThat) {
  const TetMesh block = box_mesh({14, 10, 10}, {0.3, 0.2, 0.2});
  expect_failure(run_on(block,
                        "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --solver mumps "
                        "-- -mat_mumps_icntl_23 1"),
                 1, "out of memory for the factor of the stiffness (mumps, INFOG(1) = ");
}

TEST_F(PrecomputeProgram, DerivativesThatDoNotBalanceAreRefused) {
  const TetMesh block = box_mesh({8, 4, 4}, {0.3, 0.15, 0.15});
  expect_failure(run_on(block,
                        "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --solver "
                        "iterative -- -cg_ksp_rtol 1e-3"),
                 4, "residual of the modes");
}

TEST_F(PrecomputeProgram, AUnitScalesATetrahedralMeshLikeASurface) {
  const auto report = [&](const std::string& arguments) {
    const ProgramResult result =
        run(arguments +
            " -o scaled.tremolo --linear-modes 4 --modes 8 --json --point-mass "
            "'x>99%=0.5'");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  TetMesh millimetres = block_;
  for (Eigen::Vector3d& x : millimetres.vertices) x *= 1000.0;
  write_veg(folder_ + "/mm.veg", millimetres);
  const auto metres = report("block.veg --fix 'x<0.001'");
  for (const char* unit : {"--unit mm", "--unit 0.001", "--mesh-unit mm"}) {
    const auto scaled = report(std::string("mm.veg --fix 'x<0.001' ") + unit);
    for (std::size_t i = 0; i < 8; ++i) {
      const double f = metres["frequencies_hz"][i];
      EXPECT_NEAR(scaled["frequencies_hz"][i], f, 1e-8 * f) << unit;
    }
    EXPECT_NEAR(scaled["total_mass_kg"], metres["total_mass_kg"].get<double>(), 1e-9);
    EXPECT_NE(scaled["notes"].dump().find("the mesh's unit: "), std::string::npos);
  }
  // Nothing is said about a body of 0.4 m; one of 400 m may be in millimetres.
  EXPECT_EQ(metres["notes"].dump().find("--unit"), std::string::npos) << metres["notes"];
  const std::string doubts = report("mm.veg --fix 'x<1'")["notes"].dump();
  EXPECT_NE(doubts.find("m across: if its unit is not 1 m, say so, as in --unit mm"),
            std::string::npos)
      << doubts;
  expect_failure(run(std::string("block.veg --unit inch ") + kGood), 2, "inch");
}

TEST_F(PrecomputeProgram, OptionsOfMeshingASurfaceAreRefusedForATetrahedralMesh) {
  for (const char* option : {"--tets 3000", "--size 0.1", "--error 0.01", "--thicken 0.01",
                             "--fill-holes", "--keep-crumbs"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
    expect_failure(run(std::string("block.veg ") + option + " " + kGood), 2,
                   name + " applies to meshing a surface: block.veg is tetrahedra already");
  }
}

TEST_F(PrecomputeProgram, NumbersThatMakeNoSenseAreRefusedInOneLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"--threads 0", "--threads: expected a whole number from 1 to 2147483647, found 0"},
      {"--threads -2", "--threads: expected a whole number from 1 to 2147483647, found -2"},
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

TEST_F(PrecomputeProgram, MemoryThatWillNotDoIsToldInWholeSentences) {
  const ProgramResult result = run(std::string("block.veg --memory 1kb ") + kGood);
  expect_failure(result, 1,
                 "but 1e-06 GB are allowed by --memory. Take more ranks on more machines");
}

// Whatever the limit is, it ends: with the file, or with a message that says so. Below 200 MB the
// system cannot load the program's libraries, and says that itself.
TEST_F(PrecomputeProgram, UnderALimitOfAddressSpaceItEndsInWords) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take the address space for themselves";
#endif
  const TetMesh block = box_mesh({14, 8, 8}, {0.3, 0.2, 0.2});
  write_veg(folder_ + "/larger.veg", block);
#ifdef TREMOLO_LONG_TESTS
  constexpr int kFine = 20'000;
#else
  constexpr int kFine = 50'000;
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
  const ProgramResult told = run_program(
      folder_, "ulimit -v 400000; OPENBLAS_NUM_THREADS=2 " + kPrecompute + "block.veg " + kGood);
  expect_failure(told, 1,
                 "MB of address space would do for the start, the limit (ulimit -v) is 410 MB");
  expect_failure(told, 1, "with OPENBLAS_NUM_THREADS=1 and --threads 1 it is ");
}

// 107 modes of 135 dofs: 5 992 columns, of which 135 are independent.
TEST_F(PrecomputeProgram, ManyModesOfASmallMeshTakeSecondsAndAreHeardOf) {
  write_veg(folder_ + "/small.veg", box_mesh({5, 2, 2}, {0.5, 0.2, 0.2}));
  const ProgramResult result = run_program(
      folder_, "timeout -s KILL 100 " + kPrecompute +
                   "small.veg -o many.tremolo --order 1 --fix 'x<0.001' --linear-modes 107 "
                   "--modes 20 --threads 2 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("basis: 5992 columns will take about"), std::string::npos)
      << result.err;
  EXPECT_NE(result.err.find("basis: singular values of 135 rows"), std::string::npos);
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
  EXPECT_EQ(report["cut_singular_values"].size(), 135 - 20);
}

TEST_F(PrecomputeProgram, LayersAcrossWallsAndWhatTheyMeanAreTold) {
  write_veg(folder_ + "/plate.veg", box_mesh({12, 12, 1}, {0.4, 0.4, 0.01}));
  const ProgramResult result =
      run("plate.veg -o plate.tremolo --fix 'x<0.001' --poisson 0.49 --linear-modes 3 --order 1 "
          "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("are 1 layers of linear tetrahedra thick and nu is 0.49: frequencies "
                            "of bending come out too high, by about"),
            std::string::npos)
      << result.err;
  const auto locking = nlohmann::json::parse(result.out)["locking"];
  EXPECT_NEAR(locking["wall_thickness_m"], 0.01, 1e-12);
  EXPECT_NEAR(locking["layers"], 1.0, 1e-9);
  EXPECT_EQ(locking["poisson"], 0.49);
  EXPECT_GT(locking["frequency_excess"], 1.0);
}

// Their frequencies lie so close together that a small basis of vectors does not tell them apart;
// one vector at a time takes minutes of a hundred larger parts.
TEST_F(PrecomputeProgram, FreePartsOfMuchTheSameShapeAreSolvedForInBlocks) {
  constexpr int kParts = 60;
  TetMesh many;
  for (int i = 0; i < kParts; ++i) {
    const Eigen::Vector3d size = (1.0 + 0.001 * i) * Eigen::Vector3d(0.1, 0.11, 0.123);
    testing::add_apart(many, box_mesh({2, 2, 2}, size), {0.5 * i, 0, 0});
  }
  const ProgramResult result =
      run_on(many, "-o many.tremolo --fix none --linear --linear-modes 12 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("(block Lanczos, shift-invert)"), std::string::npos) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["rigid_modes"], 6 * kParts);
  EXPECT_TRUE(report["certified_by_inertia"]);
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
}

TEST_F(PrecomputeProgram, MoreFreePartsThanCanBeTakenAreRefusedAtOnce) {
  const TetMesh cube = box_mesh({1, 1, 1}, {0.1, 0.1, 0.1});
  TetMesh many;
  for (int i = 0; i < 1001; ++i) testing::add_apart(many, cube, {0.3 * i, 0, 0});
  expect_failure(run_on(many, "-o out.tremolo --fix none"), 3,
                 "a free body of 1001 parts that do not touch");
}

TEST_F(PrecomputeProgram, AHoldThatIsNotEnoughSaysWhatIsLeft) {
  expect_failure(run("block.veg -o out.tremolo --fix vertex:0,1,2"), 3,
                 "1 rigid motion is left (rotation about the line through vertex");
  expect_failure(run("block.veg -o out.tremolo --fix vertex:3"), 3,
                 "rotations about vertex 3 at 0.3, 0, 0, the only fixed one");
}

TEST_F(PrecomputeProgram, ADefaultDoesNotCutAPairOfModesAndAGivenCutIsTold) {
  const TetMesh beam = testing::symmetric_box({8, 2, 2}, {0.4, 0.1, 0.1});
  const ProgramResult whole = run_on(beam, "-o whole.tremolo --order 1 --fix 'x<-0.199' --json");
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(nlohmann::json::parse(whole.out)["linear_modes"], 21);
  EXPECT_NE(whole.err.find("21 linear modes, not 20"), std::string::npos) << whole.err;
  const ProgramResult cut =
      run("changed.veg -o cut.tremolo --order 1 --fix 'x<-0.199' --linear-modes 20");
  ASSERT_EQ(cut.code, 0) << cut.err;
  EXPECT_NE(cut.err.find("--linear-modes 21 takes both"), std::string::npos) << cut.err;
}

TEST_F(PrecomputeProgram, BadMeshesAreRefusedWithoutTouchingTheOutput) {
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

TEST_F(PrecomputeProgram, RepairsAndOdditiesAreReported) {
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

TEST_F(PrecomputeProgram, ImpossibleMaterialsAreRefused) {
  for (const char* bad :
       {"--poisson 0.5", "--poisson 0.7", "--poisson=-1", "--poisson nan", "--young 0",
        "--young=-5", "--young inf", "--density 0", "--density=-1", "--density nan"})
    expect_failure(run(std::string("block.veg ") + bad + " " + kGood), 3, "must be");
}

TEST_F(PrecomputeProgram, ImpossibleConstraintsAndCountsAreRefused) {
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
  expect_failure(run(std::string("block.veg --load-at 'x>0.39' ") + kGood), 3, "--load-force");
}

TEST_F(PrecomputeProgram, WrongUsageIsToldApart) {
  expect_failure(run(std::string("block.veg --no-such-flag ") + kGood), 2, "no-such-flag");
  expect_failure(run("-o out.tremolo"), 2, "mesh");
  expect_failure(run("block.veg -o out.tremolo --fix 'x<<1'"), 2, "x<<1");
  expect_failure(run(std::string("block.veg --load-at 'x>0.39' --load-force 1,2 ") + kGood), 2,
                 "--load-force");
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_EQ(run("--version").code, 0);
}

TEST_F(PrecomputeProgram, AnUnwritableOutputIsASystemError) {
  const std::string rest = " --fix 'x<0.001' --linear-modes 4 --modes 8";
  expect_failure(run("block.veg -o no/such/folder/x.tremolo" + rest), 1, "no/such/folder");
  expect_failure(run("block.veg -o /dev/full" + rest), 1, "/dev/full");
  expect_failure(run("block.veg -o ." + rest), 1, "regular file");
}

TEST_F(PrecomputeProgram, CtrlCAndTermLeaveTheOldOutputAlone) {
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
