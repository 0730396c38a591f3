// The precompute's own solvers against dense algebra.
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/fem/element_group.h"
#include "precompute/fem/matrices.h"
#include "precompute/modes/block_lanczos.h"
#include "precompute/modes/certificate.h"
#include "precompute/modes/modes.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/solver/sparse_cholesky.h"
#include "precompute/system/failure.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::SolvedPencil;
using testing::vertices_on_plane;

struct SolvedSystem {
  TetMesh mesh;
  DofMap map;
  LocalDofs local;
  Solid solid;
  Matrices matrices;

  SolvedSystem(const std::array<int, 3>& cells, const Eigen::Vector3d& size, bool clamped)
      : mesh(box_mesh(cells, size)),
        map(make_dof_map(mesh, clamped ? vertices_on_plane(mesh, 0, 0.0) : std::vector<VertexId>{},
                         1)),
        local(local_dofs(mesh, map, 0)),
        solid(make_solid(mesh, {1e6, 0.4, 1100.0})),
        matrices(assemble(solid, map, local, MassKind::kConsistent)) {}

  Eigen::MatrixXd dense(const PetscMatrix& matrix) const {
    return tremolo::multiply(matrix.get(), Eigen::MatrixXd::Identity(local.dofs(), local.dofs()));
  }
};

Columns random_columns(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return Columns::NullaryExpr(rows, columns, [&] { return uniform(engine); });
}

TEST(SparseCholesky, SolvesAnyNumberOfColumnsInPlaceOrNot) {
  // Flat and compact: supernodes from one column to some dozens, whole tiles and remainders.
  for (const std::array<int, 3>& cells : {std::array{6, 2, 3}, {7, 5, 5}, {20, 1, 1}}) {
    const SolvedSystem system(cells, {0.6, 0.2, 0.25}, true);
    const SparseCholesky factor(sparse_rows(system.matrices.stiffness.get()));
    const Eigen::MatrixXd k = system.dense(system.matrices.stiffness);
    const Eigen::LLT<Eigen::MatrixXd> reference(k);
    SparseCholesky::Workspace workspace;
    for (Eigen::Index columns : {1, 7, 8, 9, 16, 17, 37}) {
      const Columns b = random_columns(k.rows(), columns);
      Columns x(b.rows(), b.cols());
      factor.solve(b, x, workspace);
      // Both are wrong by the condition of K (1e4 here) times rounding.
      const Columns expected = reference.solve(b);
      EXPECT_LE((x - expected).norm(), 1e-11 * expected.norm()) << columns;
      EXPECT_LE((k * x - b).norm(), 1e-11 * b.norm()) << columns;
      Columns in_place = b;
      factor.solve(in_place, in_place, workspace);
      EXPECT_EQ(in_place, x);
    }
  }
}

TEST(SparseCholesky, AColumnDoesNotDependOnItsNeighbours) {
  const SolvedSystem system({7, 4, 5}, {0.6, 0.2, 0.25}, true);
  const SparseCholesky factor(sparse_rows(system.matrices.stiffness.get()));
  SparseCholesky::Workspace workspace;
  const Columns b = random_columns(system.local.dofs(), 8);
  Columns together(b.rows(), 8), alone(b.rows(), 1);
  factor.solve(b, together, workspace);
  factor.solve(b.col(5), alone, workspace);
  EXPECT_EQ(together.col(5), alone.col(0));
}

TEST(SparseCholesky, AnIndefiniteMatrixIsRefused) {
  const SolvedSystem system({6, 2, 3}, {0.6, 0.2, 0.25}, true);
  PetscMatrix shifted;
  ASSERT_EQ(MatDuplicate(system.matrices.stiffness.get(), MAT_COPY_VALUES, shifted.out()), 0);
  // Above many eigenvalues: CHOLMOD meets a negative pivot.
  ASSERT_EQ(MatAXPY(shifted.get(), -1e6, system.matrices.mass.get(), SUBSET_NONZERO_PATTERN), 0);
  EXPECT_THROW(SparseCholesky(sparse_rows(shifted.get())), Failure);
}

TEST(SparseRows, MultiplyAsPetscDoes) {
  const SolvedSystem system({5, 3, 2}, {0.6, 0.2, 0.25}, false);
  const Columns x = random_columns(system.local.dofs(), 7);
  Columns y(x.rows(), x.cols());
  multiply(sparse_rows(system.matrices.stiffness.get()), x, y);
  const Columns expected = multiply(system.matrices.stiffness.get(), x);
  EXPECT_LE((y - expected).norm(), 1e-15 * expected.norm() * 10);  // another order of the sum
}

// The largest distance of the pairs from what a dense solver finds, relative.
void expect_lowest_modes(const SolvedSystem& system, const LanczosPairs& pairs, int left_out,
                         double shift) {
  const Eigen::MatrixXd m = system.dense(system.matrices.mass);
  const EigenPairs reference = eigenpairs(system.dense(system.matrices.stiffness), m);
  ASSERT_TRUE(pairs.converged);
  const Eigen::Index wanted = pairs.values.size();
  for (Eigen::Index i = 0; i < wanted; ++i) {
    const double value = 1.0 / pairs.values[i] + shift;
    EXPECT_NEAR(value, reference.values[i + left_out], 1e-9 * value);
  }
  const Eigen::MatrixXd gram = pairs.vectors.transpose() * m * pairs.vectors;
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(wanted, wanted)).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(BlockLanczos, FindsTheLowestModesOfAClampedBlock) {
  const SolvedSystem system({8, 4, 4}, {0.6, 0.2, 0.2}, true);  // a square section: double modes
  SolvedPencil solved(system.matrices, 2);
  solved.solver->prepare(0.0);
  expect_lowest_modes(system, block_lanczos(solved.pencil, *solved.solver, 15, 1e-11), 0, 0.0);
}

TEST(BlockLanczos, DoesNotDependOnTheThreads) {
  const SolvedSystem system({8, 4, 4}, {0.6, 0.2, 0.2}, true);
  const auto pairs = [&](unsigned threads) {
    SolvedPencil solved(system.matrices, threads);
    solved.solver->prepare(0.0);
    return block_lanczos(solved.pencil, *solved.solver, 9, 1e-11);
  };
  const LanczosPairs one = pairs(1), three = pairs(3);
  EXPECT_EQ(one.values, three.values);
  EXPECT_EQ(one.vectors, three.vectors);
}

TEST(BlockLanczos, StaysAwayFromRigidMotion) {
  const SolvedSystem system({6, 4, 4}, {0.6, 0.2, 0.25}, false);
  const MeshReport report = *check_mesh(const_cast<TetMesh&>(system.mesh));
  const Columns rigid =
      rigid_modes(system.mesh, report.part_of_vertex, 1, system.local, system.matrices.mass.get());
  constexpr double kShift = -200.0;
  SolvedPencil solved(system.matrices, rigid, kShift, 2);
  solved.solver->prepare(kShift);
  expect_lowest_modes(system, block_lanczos(solved.pencil, *solved.solver, 10, 1e-11), 6, kShift);
}

TEST(BlockLanczos, EndsWhenTheSpaceDoes) {
  const SolvedSystem system({1, 1, 1}, {0.6, 0.2, 0.25}, true);  // twelve dofs, blocks of eight
  SolvedPencil solved(system.matrices, 2);
  solved.solver->prepare(0.0);
  const LanczosPairs pairs = block_lanczos(solved.pencil, *solved.solver, 5, 1e-11);
  ASSERT_TRUE(pairs.converged);
  expect_lowest_modes(system, pairs, 0, 0.0);
}

TEST(Modes, OfAFactorByMumpsAreThoseOfCholmod) {
  const SolvedSystem system({12, 5, 5}, {0.6, 0.2, 0.2}, true);  // double modes
  const Columns none(system.local.dofs(), 0);
  const Modes cholmod = SolvedPencil(system.matrices, 2).modes(9);
  const Modes mumps = SolvedPencil(system.matrices, none, 0.0, 2, LinearSolver::kMumps).modes(9);
  EXPECT_EQ(mumps.factorisation, "mumps");
  EXPECT_EQ(mumps.solver, cholmod.solver);
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(mumps.squared_frequencies[i], cholmod.squared_frequencies[i],
                1e-11 * cholmod.squared_frequencies[i]);
  EXPECT_LE(mumps.residuals.maxCoeff(), 1e-8);
}

TEST(Modes, OfALargerMeshAreTheSameByBlocksAndBySlepc) {
  const SolvedSystem system({20, 6, 6}, {0.6, 0.2, 0.25}, true);
  SolvedPencil solved(system.matrices, 2);
  const Modes blocks = solved.modes(10);
  ASSERT_GT(blocks.solves, 0);
  ASSERT_EQ(PetscOptionsSetValue(nullptr, "-eps_purify", "1"), 0);
  const Modes slepc = solved.modes(10);
  ASSERT_EQ(PetscOptionsClearValue(nullptr, "-eps_purify"), 0);
  ASSERT_EQ(slepc.solves, 0);
  for (int i = 0; i < 10; ++i)
    EXPECT_NEAR(blocks.squared_frequencies[i], slepc.squared_frequencies[i],
                1e-10 * slepc.squared_frequencies[i]);
  EXPECT_NEAR(blocks.next_squared_frequency, slepc.next_squared_frequency,
              1e-10 * slepc.next_squared_frequency);
  EXPECT_LE(blocks.residuals.maxCoeff(), 1e-8);
}

TEST(SupernodalLdl, CountsTheNegativeEigenvaluesAsMumpsDoes) {
  // Large enough that subtrees run side by side.
  const SolvedSystem system({20, 6, 6}, {0.6, 0.2, 0.25}, true);
  const Modes modes = SolvedPencil(system.matrices, 2).modes(10);
  const auto& w2 = modes.squared_frequencies;
  // -1: the factorisation, which does not pivot, was not stable.
  SparseCholesky factor(sparse_rows(system.matrices.stiffness.get()));
  const auto count = [&](double bound, unsigned threads) {
    const PetscMatrix shifted = shifted_stiffness(system.matrices, bound);
    const LdlReport report = factor.count_negative(sparse_rows(shifted.get()), threads);
    return report.growth <= 1e5 ? static_cast<int>(report.negative) : -1;
  };
  for (int i = 0; i < 9; i += 2)
    for (unsigned threads : {1u, 3u}) {
      const double between = 0.5 * (w2[i] + w2[i + 1]);
      EXPECT_EQ(count(between, threads), i + 1);
    }
  // Far up, where most panels have pivots of both signs.
  const double high = 1e3 * w2[9];
  const int expected = count_negative_by_mumps(system.matrices, high).negative;
  EXPECT_GT(expected, 500);
  const int counted = count(high, 2);
  // Without pivoting it may give up there, but not be wrong.
  if (counted >= 0) {
    EXPECT_EQ(counted, expected);
  }
}

TEST(SupernodalLdl, GrowthIsOneForADefiniteMatrix) {
  const SolvedSystem system({10, 5, 5}, {0.6, 0.2, 0.25}, true);
  const SparseRows rows = sparse_rows(system.matrices.stiffness.get());
  SparseCholesky factor(rows);
  const LdlReport report = factor.count_negative(rows, 2);
  EXPECT_EQ(report.negative, 0u);
  EXPECT_NEAR(report.growth, 1.0, 1e-12);  // sums of the diagonal's own size
}

TEST(Modes, AMissedOneIsSeenInTheMemoryOfTheFactorToo) {
  const SolvedSystem system({20, 6, 6}, {0.6, 0.2, 0.25}, true);
  SolvedPencil solved(system.matrices, 2);
  Modes modes = solved.modes(7);
  Eigen::VectorXd thinned(6);
  thinned << modes.squared_frequencies.head(2), modes.squared_frequencies.tail(4);
  modes.squared_frequencies = thinned;
  const InertiaCertificate certificate = certify(*solved.solver, modes, 0);
  EXPECT_FALSE(certificate.complete());
  EXPECT_EQ(certificate.counted, certificate.expected + 1);
  EXPECT_EQ(certificate.solver, "own");
  EXPECT_FALSE(solved.solver->ready()) << "its memory was used";
}

TEST(ElementGroup, SecondDerivativesAreThoseOfOneElementAtATime) {
  const SolvedSystem system({5, 3, 3}, {0.6, 0.2, 0.25}, true);
  const Columns fields = 0.01 * random_columns(3 * system.mesh.vertices.size(), 4);
  const std::vector<ColumnPair> pairs = {{0, 0}, {0, 1}, {2, 3}, {3, 3}};
  // 270 elements and one less: a last group that is not full.
  std::vector<int> elements = system.local.elements;
  for (int round = 0; round < 2; ++round, elements.pop_back()) {
    Columns found = Columns::Zero(system.local.dofs(), 4);
    subtract_second_derivatives(system.solid, elements, fields, pairs, system.local.row_of_vertex,
                                found.data(), static_cast<std::size_t>(found.rows()));
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      Eigen::VectorXd expected = Eigen::VectorXd::Zero(found.rows());
      add_second_derivative(system.solid, elements, fields.col(pairs[p].i), fields.col(pairs[p].j),
                            system.local.row_of_vertex, expected.data());
      EXPECT_LE((found.col(p) + expected).norm(), 1e-13 * expected.norm());
    }
  }
}

}  // namespace
}  // namespace tremolo
