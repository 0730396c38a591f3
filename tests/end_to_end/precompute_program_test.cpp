// tremolo-precompute from the user's side: its outputs and its messages.
#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"
#include "tests/support/precompute_folder.h"

namespace tremolo {
namespace {

using PrecomputeProgram = PrecomputeFolder;

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

TEST_F(PrecomputeProgram, ALinearModelIsItsLinearModesAlone) {
  const std::string linear = "block.veg -o out.tremolo --fix 'x<0.001' --linear-modes 4 --linear";
  const nlohmann::json report = report_of(linear);
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

TEST_F(PrecomputeProgram, AThinFreePlateIsComputedToo) {
  write_veg(folder_ + "/plate.veg", box_mesh({16, 16, 1}, {1.0, 1.0, 0.001}));
  const ProgramResult result = run("plate.veg -o plate.tremolo --fix none --linear-modes 6 --json");
  EXPECT_EQ(result.code, 0) << result.err;
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

// If the file is not made there, several runs cannot compete for it.
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
  // Requested settings are kept.
  const ProgramResult asked =
      run_program(folder_, "env OPENBLAS_CORETYPE=Prescott OPENBLAS_VERBOSE=2 " TREMOLO_BIN_DIR
                           "/tremolo-precompute block.veg " +
                               std::string(kGood));
  EXPECT_NE(asked.err.find("Core: Prescott"), std::string::npos) << asked.err;
#endif
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

// Their frequencies lie so close together that a small basis of vectors does not distinguish them;
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

TEST_F(PrecomputeProgram, ADefaultDoesNotCutAPairOfModesAndAGivenCutIsTold) {
  const TetMesh beam = testing::symmetric_box({8, 2, 2}, {0.4, 0.1, 0.1});
  const ProgramResult whole =
      run_on(beam, "-o whole.tremolo --order 1 --modes 29 --fix 'x<-0.199' --json");
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(nlohmann::json::parse(whole.out)["linear_modes"], 21);
  EXPECT_NE(whole.err.find("21 linear modes, not 20"), std::string::npos) << whole.err;
  const ProgramResult cut =
      run("changed.veg -o cut.tremolo --order 1 --fix 'x<-0.199' --linear-modes 20");
  ASSERT_EQ(cut.code, 0) << cut.err;
  EXPECT_NE(cut.err.find("--linear-modes 21 takes both"), std::string::npos) << cut.err;
}

}  // namespace
}  // namespace tremolo
