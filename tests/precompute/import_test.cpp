// A model of VegaFEM's, imported: the same forces in other coordinates, or a message that says what
// does not fit.
#include "precompute/vega/import.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "precompute/system/failure.h"
#include "precompute/vega/reduced_tensors.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/mesh_file.h"
#include "tests/support/meshes/vega_files.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

using namespace testing;

constexpr Eigen::Index kSize = 5;
constexpr double kDensity = 1100.0;

// Mass of each vertex, V/4 of each of its tetrahedra, added up straightforwardly.
Eigen::VectorXd lumped_masses(const TetMesh& mesh) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.vertices.size());
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) mass[v] += 0.25 * kDensity * signed_volume(mesh, tet);
  return mass.reshaped();
}

Eigen::MatrixXd lumped_matrix(const TetMesh& mesh) {
  const Eigen::VectorXd mass = lumped_masses(mesh);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * mass.size(), 3 * mass.size());
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) matrix(row, row) = mass[row / 3];
  return matrix;
}

// rho V/10 on the diagonal, rho V/20 off it.
Eigen::MatrixXd consistent_matrix(const TetMesh& mesh) {
  const Eigen::Index n = mesh.vertices.size();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId a : tet)
      for (VertexId b : tet)
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          matrix(3 * a + axis, 3 * b + axis) +=
              kDensity * signed_volume(mesh, tet) * (a == b ? 0.1 : 0.05);
  return matrix;
}

// Random columns that hold the vertices with x = 0, orthonormal in `mass`.
Eigen::MatrixXd orthonormal_basis(const TetMesh& mesh, const Eigen::MatrixXd& mass) {
  Eigen::MatrixXd basis =
      random_vector(3 * kSize * static_cast<Eigen::Index>(mesh.vertices.size()), 1.0, 5)
          .reshaped(3 * static_cast<Eigen::Index>(mesh.vertices.size()), kSize);
  for (VertexId v : vertices_on_plane(mesh, 0, 0.0)) basis.middleRows(3 * Eigen::Index{v}, 3) *= 0;
  const Eigen::MatrixXd gram = basis.transpose() * mass * basis;
  const Eigen::MatrixXd lower = gram.llt().matrixL();
  return lower.triangularView<Eigen::Lower>().solve(basis.transpose()).transpose();
}

class Import : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", mesh_);
    write("good.cub", cub_file(forces_));
    write("good.U", basis_file(basis_));
    options_.solid.files.mesh = folder_ + "/block.veg";
    options_.solid.imported = true;
    options_.basis_path = folder_ + "/good.U";
    options_.cubic_path = folder_ + "/good.cub";
    options_.solid.materials.usual.density = kDensity;
  }

  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << bytes;
  }

  ImportResult import() {
    StageLog log(true);
    return import_reduced(options_, log);
  }

  void expect_refused(const std::vector<std::string>& words) {
    try {
      import();
      FAIL() << "was imported; expected: " << words.front();
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.error().kind, ErrorKind::kContent) << failure.error().message;
      for (const std::string& word : words)
        EXPECT_NE(failure.error().message.find(word), std::string::npos)
            << "`" << word << "` is not in: " << failure.error().message;
    }
  }

  // Rows of all vertices in the mesh's order.
  static Eigen::MatrixXd rows_of(const BasisData& data) {
    Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(data.vertex_count), data.lambda.size());
    for (const VertexBlock* block : {&data.surface, &data.interior})
      for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
        rows.middleRows(3 * Eigen::Index{block->vertex_ids[i]}, 3) =
            block->rows.middleRows(3 * static_cast<Eigen::Index>(i), 3);
    return rows;
  }

  static Eigen::VectorXd gradient_of(const BasisData& data, const Eigen::VectorXd& q) {
    return gradient({data.lambda.asDiagonal(), data.cubic, data.quartic}, q);
  }

  // y = R q moves every vertex as q does: R from the two bases, not from the importer.
  static Eigen::MatrixXd change_between(const Eigen::MatrixXd& from, const BasisData& to) {
    return from.colPivHouseholderQr().solve(rows_of(to));
  }

  void expect_same_forces(const BasisData& data, const Eigen::MatrixXd& from) {
    const Eigen::MatrixXd change = change_between(from, data);
    EXPECT_LE((from * change - rows_of(data)).norm(), 1e-12 * from.norm());
    for (unsigned seed = 0; seed < 5; ++seed) {
      const Eigen::VectorXd q = random_vector(data.lambda.size(), 1.0, seed);
      const Eigen::VectorXd expected =
          change.transpose() * evaluate_rows(forces_, Eigen::VectorXd(change * q));
      EXPECT_LE((gradient_of(data, q) - expected).norm(), 1e-12 * expected.norm());
    }
  }

  TetMesh mesh_ = box_mesh({3, 2, 2}, {0.3, 0.15, 0.2});
  StrainModel model_ = random_strain_model(spread_omega(kSize, 20.0, 300.0), 0.4, 11);
  Eigen::MatrixXd turn_ = random_turn(kSize, 3);
  ForceRows forces_ = turned_forces(model_, turn_);
  Eigen::MatrixXd basis_ = orthonormal_basis(mesh_, lumped_matrix(mesh_));
  ImportRequest options_;
  std::string folder_;
};

TEST_F(Import, TheReferenceForcesAreThoseOfTheClosedForm) {
  const Eigen::VectorXd y = random_vector(kSize, 1.0, 9);
  const Eigen::VectorXd expected = turn_.transpose() * strain_force(model_, turn_ * y);
  EXPECT_LE((evaluate_rows(forces_, y) - expected).norm(), 1e-13 * expected.norm());
}

TEST_F(Import, AFullStiffnessBecomesDiagonalAndTheForcesStayTheSame) {
  const ImportResult result = import();
  const BasisData& data = result.data;
  ASSERT_EQ(data.lambda.size(), kSize);
  // The eigenvalues of a rotated diag(omega^2): rounding of the largest, 9e4.
  EXPECT_LE((data.lambda - model_.omega.cwiseAbs2()).cwiseAbs().maxCoeff(), 1e-9);
  expect_same_forces(data, basis_);
  EXPECT_LE(result.findings.force_error, 1e-13);
  EXPECT_LE(result.findings.asymmetry, 1e-13);
  const Eigen::MatrixXd rows = rows_of(data);
  EXPECT_LE(
      (rows.transpose() * lumped_matrix(mesh_) * rows - Eigen::MatrixXd::Identity(kSize, kSize))
          .cwiseAbs()
          .maxCoeff(),
      1e-12);
}

TEST_F(Import, KeepsTheFilesAndTheRestOfTheModel) {
  const ImportResult result = import();
  const BasisData& data = result.data;
  EXPECT_EQ(data.vega.basis, basis_file(basis_));
  EXPECT_EQ(data.vega.cubic, cub_file(forces_));
  EXPECT_EQ(data.vertex_count, mesh_.vertices.size());
  EXPECT_EQ(data.tetrahedron_count, mesh_.tetrahedra.size());
  EXPECT_EQ(data.fixed_vertices, vertices_on_plane(mesh_, 0, 0.0));
  EXPECT_EQ(data.rigid_mode_count, 0u);
  EXPECT_NEAR(data.total_mass, kDensity * 0.3 * 0.15 * 0.2, 1e-12 * kDensity);
  EXPECT_EQ(result.findings.mass, MassKind::kLumped);
  EXPECT_FALSE(result.findings.orthonormalised);
  EXPECT_LE(result.findings.lumped_error, 1e-13);
  EXPECT_GT(result.findings.consistent_error, 1e-3) << "the two masses differ";
}

TEST_F(Import, ADiagonalStiffnessKeepsItsNumbers) {
  write("good.cub", cub_file(turned_forces(model_, Eigen::MatrixXd::Identity(kSize, kSize))));
  const ImportResult result = import();
  BasisData expected;
  expand_coefficients(model_, expected);
  EXPECT_EQ(result.data.lambda, model_.omega.cwiseAbs2());
  EXPECT_EQ(rows_of(result.data), basis_);
  // The helper sums terms in another order.
  for (std::size_t i = 0; i < expected.cubic.size(); ++i)
    EXPECT_NEAR(result.data.cubic[i], expected.cubic[i], 1e-14 * 9e4);
}

TEST_F(Import, RowsOfFixedVerticesMayBeLeftOut) {
  const ImportResult whole = import();
  const std::vector<VertexId> fixed = vertices_on_plane(mesh_, 0, 0.0);
  Eigen::MatrixXd free(0, kSize);
  for (VertexId v = 0; v < static_cast<VertexId>(mesh_.vertices.size()); ++v) {
    if (std::binary_search(fixed.begin(), fixed.end(), v)) continue;
    free.conservativeResize(free.rows() + 3, kSize);
    free.bottomRows(3) = basis_.middleRows(3 * Eigen::Index{v}, 3);
  }
  write("good.U", basis_file(free));
  expect_refused({"good.U has 81 rows", "block.veg has 36 vertices", "108", "--fix"});
  options_.solid.support.fixed = {*parse_selector("x<0.001")};
  const ImportResult result = import();
  EXPECT_EQ(rows_of(result.data), rows_of(whole.data));
  EXPECT_EQ(result.data.fixed_vertices, whole.data.fixed_vertices);
}

// As VegaFEM's solvers leave it at a fixed vertex.
TEST_F(Import, WhatRoundingLeavesInTheRowsOfHeldVerticesIsZero) {
  const ImportResult whole = import();
  const std::vector<VertexId> held = vertices_on_plane(mesh_, 0, 0.0);
  Eigen::MatrixXd noisy = basis_;
  const double largest = noisy.cwiseAbs().maxCoeff();
  for (VertexId v : held)
    noisy.middleRows(3 * Eigen::Index{v}, 3) =
        1e-14 * largest * random_vector(3 * kSize, 1.0, 17).reshaped(3, kSize);
  write("good.U", basis_file(noisy));
  for (const std::vector<Selector>& fix : {std::vector<Selector>{}, {*parse_selector("x<0.001")}}) {
    options_.solid.support.fixed = fix;
    const ImportResult result = import();
    EXPECT_EQ(result.data.fixed_vertices, held);
    EXPECT_EQ(result.data.rigid_mode_count, 0u);
    EXPECT_EQ(rows_of(result.data), rows_of(whole.data)) << "exactly zero where held";
    EXPECT_EQ(result.data.vega.basis, basis_file(noisy)) << "the file itself stays as it was";
    EXPECT_TRUE(std::any_of(
        result.problem.notes.begin(), result.problem.notes.end(),
        [](const std::string& note) { return note.find("taken as zero") != std::string::npos; }));
  }
  // A hundred times what counts as rounding is a motion.
  for (VertexId v : held) noisy.middleRows(3 * Eigen::Index{v}, 3) *= 1e4;
  write("good.U", basis_file(noisy));
  options_.solid.support.fixed = {*parse_selector("x<0.001")};
  expect_refused({"are not zero", "rounding is below 1e-12", "--fix"});
}

TEST_F(Import, FilesThatDoNotFitEachOtherAreNamed) {
  write("good.U", basis_file(Eigen::MatrixXd(basis_.topRows(105))));
  expect_refused({"good.U has 105 rows", "block.veg has 36 vertices", "108"});
  write("good.U", basis_file(Eigen::MatrixXd(basis_.leftCols(4))));
  expect_refused({"good.U has 4 columns", "good.cub has 5 coordinates"});
  write("good.U", basis_file(basis_));
  options_.solid.support.fixed = {*parse_selector("x>0.25")};
  expect_refused({"good.U: the rows of vertex 3 are not zero", "--fix"});
}

TEST_F(Import, AnotherDensityIsToldAndTakenOnlyWhenAMassIsAskedFor) {
  options_.solid.materials.usual.density = 2.0 * kDensity;
  expect_refused({"good.U", "2 times the identity", "0.5 times as large", "--density"});
  options_.solid.elements.mass = MassKind::kLumped;
  options_.mass_given = true;
  const ImportResult result = import();
  EXPECT_TRUE(result.findings.orthonormalised);
  EXPECT_NEAR(result.findings.lumped_error, 1.0, 1e-12);
  EXPECT_LE(result.findings.orthonormality_error, 1e-12);
  // Twice the mass on the same springs.
  for (Eigen::Index i = 0; i < kSize; ++i)
    EXPECT_NEAR(result.data.lambda[i], 0.5 * model_.omega[i] * model_.omega[i], 1e-9);
  expect_same_forces(result.data, basis_);
}

TEST_F(Import, ABasisOfNeitherMassIsRefusedOrMadeOrthonormal) {
  Eigen::MatrixXd mixed = basis_;
  mixed.col(1) += 0.5 * mixed.col(0);
  write("good.U", basis_file(mixed));
  expect_refused({"U^T M U is off the identity by 0.5 in the lumped mass", "--mass lumped"});
  options_.solid.elements.mass = MassKind::kConsistent;
  options_.mass_given = true;
  const ImportResult result = import();
  EXPECT_EQ(result.findings.mass, MassKind::kConsistent);
  expect_same_forces(result.data, mixed);
  const Eigen::MatrixXd rows = rows_of(result.data);
  EXPECT_LE(
      (rows.transpose() * consistent_matrix(mesh_) * rows - Eigen::MatrixXd::Identity(kSize, kSize))
          .cwiseAbs()
          .maxCoeff(),
      1e-12);
}

TEST_F(Import, ABasisOfTheConsistentMassIsKnownByItself) {
  basis_ = orthonormal_basis(mesh_, consistent_matrix(mesh_));
  write("good.U", basis_file(basis_));
  const ImportResult result = import();
  EXPECT_EQ(result.findings.mass, MassKind::kConsistent);
  EXPECT_FALSE(result.findings.orthonormalised);
  EXPECT_LE(result.findings.consistent_error, 1e-13);
  expect_same_forces(result.data, basis_);
}

TEST_F(Import, ForcesWithoutAPotentialAreRefusedAndRoundingIsNot) {
  const double largest = forces_.rows[2].cwiseAbs().maxCoeff();
  forces_.rows[2](1, 4) += 1e-12 * largest;
  write("good.cub", cub_file(forces_));
  const ImportResult result = import();
  EXPECT_GT(result.findings.asymmetry, 1e-14);
  EXPECT_LE(result.findings.asymmetry, 1e-11);
  forces_.rows[2](1, 4) += 1e-4 * largest;
  write("good.cub", cub_file(forces_));
  expect_refused({"good.cub: the forces have no potential", "differ by"});
}

TEST_F(Import, AStiffnessThatIsNotPositiveIsRefused) {
  model_.omega[0] = 0.0;  // a rigid motion among the columns
  write("good.cub", cub_file(turned_forces(model_, turn_)));
  expect_refused({"good.cub", "squared frequency", "rigid motion"});
}

TEST_F(Import, NumbersThatOverflowAreRefused) {
  // Made orthonormal, the basis grows by a thousand and the stiffness by a million.
  for (Eigen::MatrixXd& rows : forces_.rows) rows *= 1e302;
  write("good.cub", cub_file(forces_));
  write("good.U", basis_file(1e-3 * basis_));
  options_.solid.elements.mass = MassKind::kLumped;
  options_.mass_given = true;
  EXPECT_THROW(import(), Failure);
}

TEST_F(Import, ABodyThatNothingHoldsIsFree) {
  Eigen::MatrixXd loose = Eigen::MatrixXd::Zero(basis_.rows(), kSize);
  loose = random_vector(loose.size(), 1.0, 2).reshaped(loose.rows(), kSize);
  const Eigen::MatrixXd gram = loose.transpose() * lumped_matrix(mesh_) * loose;
  const Eigen::MatrixXd lower = gram.llt().matrixL();
  loose = lower.triangularView<Eigen::Lower>().solve(loose.transpose()).transpose().eval();
  write("good.U", basis_file(loose));
  const ImportResult result = import();
  EXPECT_TRUE(result.data.fixed_vertices.empty());
  EXPECT_EQ(result.data.rigid_mode_count, 6u);
}

TEST(ReducedTensors, AChangeOfCoordinatesChangesTheEnergyAlone) {
  const StrainModel model = random_strain_model(spread_omega(4, 2.0, 9.0), 0.5, 6);
  BasisData data;
  expand_coefficients(model, data);
  // Any invertible change, not only a rotation.
  const Eigen::MatrixXd change = random_vector(16, 1.0, 4).reshaped(4, 4);
  const ReducedTensors changed =
      change_coordinates({model.omega.cwiseAbs2().asDiagonal(), data.cubic, data.quartic}, change);
  const Eigen::VectorXd q = random_vector(4, 1.0, 5);
  const Eigen::VectorXd expected = change.transpose() * strain_force(model, change * q);
  EXPECT_LE((gradient(changed, q) - expected).norm(), 1e-13 * expected.norm());
}

}  // namespace
}  // namespace tremolo
