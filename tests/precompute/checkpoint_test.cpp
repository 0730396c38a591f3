// Stages kept and found again: every bit, of the right shape, of the same identity; and the factor
// that is made again.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "precompute/checkpoint/checkpoint_stages.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/system/failure.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/run_program.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::vertices_on_plane;

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns) {
  static std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(engine); });
}

template <class A, class B>
bool same_bits(const A& a, const B& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

// A run with checkpoints in a folder of its own, and further ones that resume it.
class StagesKept : public ::testing::Test {
 protected:
  StagesKept() {
    request_.folder = checkpoint_folder(testing::fresh_folder() + "/out");
    request_.keep = true;
  }
  Checkpoint start() { return {request_, identity_, log_}; }
  Checkpoint resume() {
    CheckpointRequest request = request_;
    request.resume = true;
    return {request, identity_, log_};
  }
  std::string file(const std::string& stage) const { return request_.folder + "/" + stage + ".0"; }

  CheckpointRequest request_;
  CheckpointIdentity identity_ = {{"mesh", "1234"}, {"linear modes", "3"}};
  StageLog log_{true};
};

WholeModes some_modes() {
  WholeModes whole;
  Modes& modes = whole.modes;
  modes.squared_frequencies = random_matrix(3, 1);
  modes.vectors = random_matrix(12, 3);
  modes.vectors(4, 1) = -0.0;
  modes.residuals = random_matrix(3, 1);
  modes.scaled_residual = 1e-300;
  modes.next_squared_frequency = 7;
  modes.cancellation = 1.0 / 3.0;
  modes.shift = -5e-324;
  modes.solves = 31;
  modes.solver = "somebody";
  modes.factorisation = "";
  modes.left_out = {7, 8};
  whole.note = "a note";
  return whole;
}

TEST_F(StagesKept, ModesComeBackBitForBit) {
  const WholeModes whole = some_modes();
  Checkpoint first = start();
  keep_modes(first, whole);
  Checkpoint second = resume();
  const std::optional<WholeModes> again = find_modes(second, 12, 3);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->note, whole.note);
  const Modes &modes = whole.modes, &found = again->modes;
  EXPECT_EQ(found.left_out, modes.left_out);
  EXPECT_TRUE(same_bits(found.squared_frequencies, modes.squared_frequencies));
  EXPECT_TRUE(same_bits(found.vectors, modes.vectors));
  EXPECT_TRUE(same_bits(found.residuals, modes.residuals));
  EXPECT_EQ(found.scaled_residual, modes.scaled_residual);
  EXPECT_EQ(found.next_squared_frequency, modes.next_squared_frequency);
  EXPECT_EQ(found.cancellation, modes.cancellation);
  EXPECT_EQ(found.shift, modes.shift);
  EXPECT_EQ(found.solves, modes.solves);
  EXPECT_EQ(found.solver, modes.solver);
  EXPECT_EQ(found.factorisation, modes.factorisation);
}

TEST_F(StagesKept, DerivativesComeBackBehindTheModes) {
  ModalDerivatives derivatives{random_matrix(12, 9), 3, 0.25};
  Checkpoint first = start();
  keep_derivatives(first, derivatives);
  Checkpoint second = resume();
  const auto found = find_derivatives(second, derivatives.columns.leftCols(3));
  ASSERT_TRUE(found);
  EXPECT_TRUE(same_bits(found->columns, derivatives.columns));
  EXPECT_EQ(found->modes, 3);
  EXPECT_EQ(found->residual, 0.25);
}

TEST_F(StagesKept, CertificateBasisAndCoefficientsComeBack) {
  InertiaCertificate certificate{2.5, 3, 3, "own"};
  FinishedBasis basis;
  basis.rows = random_matrix(15, 4);
  basis.basis.lambda = random_matrix(4, 1);
  basis.basis.singular_values = {3, 2, 1, 0.5, 0.25};
  basis.basis.orthonormality_error = 1e-15;
  basis.basis.diagonality_error = 2e-15;
  basis.basis.cut = {3, 2};
  basis.derivative_residual = 3e-15;
  FinishedCoefficients coefficients;
  coefficients.cubic.assign(triple_count(4), 0.125);
  coefficients.quartic.assign(quad_count(4), -0.125);
  coefficients.strain_gram.assign(pair_count(strain_terms(4)), 0.5);
  coefficients.polynomial_error = 4e-15;
  Checkpoint first = start();
  keep_certificate(first, certificate);
  keep_basis(first, basis);
  keep_coefficients(first, coefficients);

  Checkpoint second = resume();
  const auto found_certificate = find_certificate(second);
  const auto found_basis = find_basis(second, 15, 4);
  const auto found_coefficients = find_coefficients(second, 4);
  ASSERT_TRUE(found_certificate && found_basis && found_coefficients);
  EXPECT_EQ(found_certificate->bound, 2.5);
  EXPECT_TRUE(found_certificate->complete());
  EXPECT_EQ(found_certificate->counted, 3);
  EXPECT_EQ(found_certificate->solver, "own");
  EXPECT_TRUE(same_bits(found_basis->rows, basis.rows));
  EXPECT_TRUE(same_bits(found_basis->basis.lambda, basis.basis.lambda));
  EXPECT_EQ(found_basis->basis.singular_values, basis.basis.singular_values);
  EXPECT_EQ(found_basis->basis.orthonormality_error, 1e-15);
  EXPECT_EQ(found_basis->basis.diagonality_error, 2e-15);
  EXPECT_EQ(found_basis->basis.cut.first, 3);
  EXPECT_EQ(found_basis->basis.cut.count, 2);
  EXPECT_EQ(found_basis->derivative_residual, 3e-15);
  EXPECT_EQ(found_coefficients->cubic, coefficients.cubic);
  EXPECT_EQ(found_coefficients->quartic, coefficients.quartic);
  EXPECT_EQ(found_coefficients->polynomial_error, 4e-15);
}

TEST_F(StagesKept, WhatHasAnotherShapeIsNotFound) {
  Checkpoint first = start();
  keep_modes(first, some_modes());
  keep_derivatives(first, {random_matrix(12, 9), 3, 0.25});
  Checkpoint second = resume();
  EXPECT_FALSE(find_modes(second, 15, 3));
  EXPECT_FALSE(find_modes(second, 12, 4));
  EXPECT_TRUE(find_modes(second, 12, 2)) << "one more than asked for";
  EXPECT_FALSE(find_derivatives(second, random_matrix(12, 2)));
  EXPECT_FALSE(find_derivatives(second, random_matrix(9, 3)));
  EXPECT_FALSE(find_basis(second, 12, 3)) << "nobody kept one";
}

TEST_F(StagesKept, AnotherIdentityIsAFailureThatNamesWhatDiffers) {
  Checkpoint first = start();
  keep_modes(first, some_modes());
  identity_[1].second = "4";
  try {
    resume();
    FAIL() << "resumed";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kContent);
    EXPECT_NE(failure.error().message.find("linear modes (3 there, 4 here)"), std::string::npos)
        << failure.error().message;
    EXPECT_EQ(failure.error().message.find("mesh"), std::string::npos);
  }
}

TEST_F(StagesKept, ARunThatDoesNotResumeFindsNothing) {
  Checkpoint first = start();
  keep_modes(first, some_modes());
  EXPECT_FALSE(find_modes(first, 12, 3));
  Checkpoint second = start();
  EXPECT_FALSE(std::filesystem::exists(file("modes")));
}

TEST_F(StagesKept, AFileCutAnywhereIsNotFound) {
  Checkpoint first = start();
  keep_modes(first, some_modes());
  const std::string bytes = testing::slurp(file("modes"));
  for (std::size_t length = 0; length < bytes.size(); length += 13) {
    std::ofstream(file("modes"), std::ios::binary | std::ios::trunc) << bytes.substr(0, length);
    Checkpoint second = resume();
    EXPECT_FALSE(find_modes(second, 12, 3)) << length;
  }
}

// Held and free, each with its own shift.
TEST(RestoredFactor, SolvesBitForBitAsTheFirst) {
  for (const bool clamped : {true, false}) {
    const TetMesh mesh = box_mesh({10, 4, 4}, {0.6, 0.2, 0.25});
    const DofMap map =
        make_dof_map(mesh, clamped ? vertices_on_plane(mesh, 0, 0.0) : std::vector<VertexId>{}, 1);
    const LocalDofs local = local_dofs(mesh, map, 0);
    const Solid solid = make_solid(mesh, {1e6, 0.4, 1100.0});
    const Matrices matrices = assemble(solid, map, local, MassKind::kConsistent);
    const Columns rigid = clamped ? Columns(local.dofs(), 0)
                                  : rigid_modes(mesh, std::vector<int>(mesh.vertices.size(), 0), 1,
                                                local, matrices.mass.get());
    testing::SolvedPencil solved(matrices, rigid, clamped ? 0.0 : -2e3);
    ShiftedSolver& solver = *solved.solver;
    const Columns loads = random_matrix(local.dofs(), 9);
    Columns first(loads.rows(), loads.cols()), second = first;
    solver.prepare(solved.shift);
    solver.solve(loads, first);
    solver.release();
    EXPECT_FALSE(solver.ready());
    solver.prepare(solved.shift);
    solver.solve(loads, second);
    EXPECT_TRUE(same_bits(first, second)) << clamped;
  }
}

}  // namespace
}  // namespace tremolo
