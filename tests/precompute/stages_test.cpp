// Each stage against the property that defines it, on a small clamped or free block.
#include <set>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/packed_index.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/modes/certificate.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/reduction/polynomial_check.h"
#include "precompute/reduction/third_derivatives.h"
#include "precompute/system/failure.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::SolvedPencil;
using testing::vertices_on_plane;

const Material kRubber{1e6, 0.4, 1100.0};

// Everything up to the matrices.
struct Block : testing::AssembledBody {
  Block(const TetMesh& source, bool clamped, MassKind mass = MassKind::kConsistent)
      : AssembledBody(source, {{{"", kRubber}}, {}},
                      clamped ? vertices_on_plane(source, 0, 0.0) : std::vector<VertexId>{}, {},
                      mass) {}

  Columns rigid() const {
    return rigid_modes(mesh, report.part_of_vertex, static_cast<int>(report.parts), local,
                       matrices.mass.get());
  }
};

Block clamped_block(MassKind mass = MassKind::kConsistent) {
  return Block(box_mesh({6, 2, 3}, {0.6, 0.18, 0.25}), true, mass);
}
Block free_block() {
  return Block(box_mesh({6, 2, 3}, {0.6, 0.18, 0.25}), false);
}

// The second derivative of the elastic force along the columns i and j of psi, over the free rows.
Eigen::VectorXd second_derivative(const Block& block, const Eigen::MatrixXd& psi, std::size_t i,
                                  std::size_t j) {
  Eigen::VectorXd h = Eigen::VectorXd::Zero(block.local.dofs());
  add_second_derivative(block.solid, block.local.elements, psi.col(i), psi.col(j),
                        block.local.row_of_vertex, h.data());
  return h;
}

constexpr double kFreeShift = -200.0;  // well below the first elastic mode of the free block

Eigen::MatrixXd dense(Mat matrix, int size) {
  return multiply(matrix, Eigen::MatrixXd::Identity(size, size));
}

TEST(DofMap, EveryFreeVertexIsANodeOnceAndFixedOnesNever) {
  const Block block = clamped_block();
  std::set<int> seen(block.map.vertex_of_node.begin(), block.map.vertex_of_node.end());
  EXPECT_EQ(seen.size(), block.mesh.vertices.size() - block.fixed.size());
  for (VertexId v : block.fixed) EXPECT_EQ(block.map.node_of_vertex[v], -1);
  for (int node = 0; node < block.map.nodes(); ++node)
    EXPECT_EQ(block.map.node_of_vertex[block.map.vertex_of_node[node]], node);
}

TEST(DofMap, RanksShareTheNodesWithoutGapsAndEachSeesItsElements) {
  const TetMesh mesh = box_mesh({6, 2, 3}, {0.6, 0.18, 0.25});
  const DofMap map = make_dof_map(mesh, {}, 3);
  ASSERT_EQ(map.rank_begin.size(), 4u);
  EXPECT_EQ(map.rank_begin.front(), 0);
  EXPECT_EQ(map.rank_begin.back(), map.nodes());
  std::set<int> rows;
  std::set<std::size_t> counted;
  for (int rank = 0; rank < 3; ++rank) {
    const LocalDofs local = local_dofs(mesh, map, rank);
    EXPECT_GT(local.nodes, 0);
    for (int row : local.row_of_vertex) {
      if (row < 0) continue;
      EXPECT_TRUE(rows.insert(3 * local.first_node + row).second);
    }
    for (std::size_t i = 0; i < local.counted; ++i)
      EXPECT_TRUE(counted.insert(local.tetrahedra[i]).second);
    // The part is cut out as it is, and every element around an own node is in it.
    const TetMesh part = part_mesh(mesh, local);
    std::size_t touched = 0;
    for (const Tetrahedron& tet : mesh.tetrahedra)
      touched += std::any_of(tet.begin(), tet.end(), [&](VertexId v) {
        const int node = map.node_of_vertex[v];
        return node >= map.rank_begin[rank] && node < map.rank_begin[rank + 1];
      });
    EXPECT_EQ(part.tetrahedra.size(), touched);
    for (std::size_t i = 0; i < part.tetrahedra.size(); ++i)
      EXPECT_EQ(signed_volume(part, part.tetrahedra[i]),
                signed_volume(mesh, mesh.tetrahedra[local.tetrahedra[i]]));
  }
  EXPECT_EQ(rows.size(), mesh.vertices.size());
  EXPECT_EQ(counted.size(), mesh.tetrahedra.size());
}

TEST(Matrices, AreSymmetricAndRigidMotionIsTheNullSpaceOfTheFreeStiffness) {
  const Block block = free_block();
  const int size = block.local.dofs();
  const Eigen::MatrixXd k = dense(block.matrices.stiffness.get(), size);
  const Eigen::MatrixXd m = dense(block.matrices.mass.get(), size);
  EXPECT_LE((k - k.transpose()).cwiseAbs().maxCoeff(), 1e-14 * k.cwiseAbs().maxCoeff());
  EXPECT_LE((m - m.transpose()).cwiseAbs().maxCoeff(), 1e-14 * m.cwiseAbs().maxCoeff());
  const Columns rigid = block.rigid();
  EXPECT_LE((rigid.transpose() * m * rigid - Eigen::MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(),
            1e-12);
  EXPECT_LE((k * rigid).norm(), 1e-12 * k.norm() * rigid.norm());
}

TEST(Modes, AgreeWithADenseEigensolver) {
  for (MassKind mass : {MassKind::kConsistent, MassKind::kLumped}) {
    const Block block = clamped_block(mass);
    const int size = block.local.dofs();
    SolvedPencil solved(block.matrices, 2);
    const Modes modes = solved.modes(8);
    const EigenPairs reference = eigenpairs(dense(block.matrices.stiffness.get(), size),
                                            dense(block.matrices.mass.get(), size));
    for (int i = 0; i < 8; ++i)
      EXPECT_NEAR(modes.squared_frequencies[i], reference.values[i], 1e-9 * reference.values[i]);
    EXPECT_NEAR(modes.next_squared_frequency, reference.values[8], 1e-9 * reference.values[8]);
    EXPECT_LE(modes.residuals.maxCoeff(), 1e-8);
    EXPECT_EQ(modes.factorisation, "cholmod");
  }
}

TEST(Modes, OfAFreeBodyLeaveRigidMotionOut) {
  const Block block = free_block();
  const int size = block.local.dofs();
  const Columns rigid = block.rigid();
  SolvedPencil solved(block.matrices, rigid, kFreeShift);
  const Modes modes = solved.modes(6);
  const EigenPairs reference = eigenpairs(dense(block.matrices.stiffness.get(), size),
                                          dense(block.matrices.mass.get(), size));
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(modes.squared_frequencies[i], reference.values[i + 6],
                1e-8 * reference.values[i + 6]);
  EXPECT_LE((rigid.transpose() * multiply(block.matrices.mass.get(), modes.vectors)).norm(), 1e-9);
}

TEST(Modes, InertiaCountsThemAndWouldSeeAMissedOne) {
  const Block block = clamped_block();
  SolvedPencil solved(block.matrices);
  Modes modes = solved.modes(7);
  for (int i = 0; i < 6; ++i) {
    const double between = 0.5 * (modes.squared_frequencies[i] + modes.squared_frequencies[i + 1]);
    EXPECT_EQ(count_negative_by_mumps(block.matrices, between).negative, i + 1);
  }
  EXPECT_TRUE(certify(*solved.solver, modes, 0).complete());
  // Lose the third mode, as a badly chosen shift can.
  Eigen::VectorXd thinned(6);
  thinned << modes.squared_frequencies.head(2), modes.squared_frequencies.tail(4);
  modes.squared_frequencies = thinned;
  EXPECT_FALSE(certify(*solved.solver, modes, 0).complete());
}

TEST(Modes, InertiaCountsTheRigidOnesOfAFreeBody) {
  const Block block = free_block();
  SolvedPencil solved(block.matrices, block.rigid(), kFreeShift);
  const Modes modes = solved.modes(5);
  const InertiaCertificate certificate = certify(*solved.solver, modes, 6);
  EXPECT_EQ(certificate.counted, 11);
  EXPECT_TRUE(certificate.complete());
}

TEST(Modes, MoreThanTheMeshHasAreRefused) {
  const Block block = clamped_block();
  SolvedPencil solved(block.matrices);
  EXPECT_THROW(solved.modes(block.local.dofs() + 1), Failure);
  EXPECT_THROW(solved.modes(0), Failure);
}

TEST(RigidFreedom, CountsTheMotionsThatFixedVerticesLeave) {
  const TetMesh mesh = box_mesh({1, 1, 1}, {1, 1, 1});
  const std::vector<int> part(mesh.vertices.size(), 0);
  const auto freedom = [&](const std::vector<VertexId>& fixed) {
    return rigid_freedom(mesh, part, 1, fixed).front();
  };
  EXPECT_EQ(freedom({}), 6);
  EXPECT_EQ(freedom({0}), 3);        // rotation about a point
  EXPECT_EQ(freedom({0, 1}), 1);     // rotation about an edge
  EXPECT_EQ(freedom({0, 1, 2}), 0);  // a triangle holds it
}

// A clamped block of linear or quadratic elements with its lowest modes and their derivatives.
struct DerivedBlock {
  Block block;
  SolvedPencil solved;
  Modes modes;
  Eigen::MatrixXd psi;
  ModalDerivatives derivatives;

  DerivedBlock(int order, int count)
      : block(testing::of_order(box_mesh({6, 2, 3}, {0.6, 0.18, 0.25}), order), true),
        solved(block.matrices, 2),
        modes(solved.modes(count)),
        psi(expand_to_vertices(block.map, block.local, modes.vectors)),
        derivatives(modal_derivatives(block.solid, block.local, solved.pencil, *solved.solver,
                                      modes.vectors, psi)) {}
};

class BlockDerivatives : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, BlockDerivatives, ::testing::Values(1, 2));

TEST_P(BlockDerivatives, SolveTheirDefiningEquation) {
  const DerivedBlock derived(GetParam(), 4);
  const Block& block = derived.block;
  const Eigen::MatrixXd& psi = derived.psi;
  const Columns phi = derived.derivatives.vectors();
  ASSERT_EQ(phi.cols(), 10);
  const Columns left = multiply(block.matrices.stiffness.get(), phi);
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      const Eigen::VectorXd h = second_derivative(block, psi, i, j);
      const auto column = left.col(pair_index(i, j));
      EXPECT_LE((column + h).norm(), 1e-9 * h.norm());  // condition of K times rounding
    }
}

// Along u(p) = Psi p + 1/2 Phi p^2 the static force stays K Psi p to second order.
TEST_P(BlockDerivatives, AreTheCurvatureOfTheStaticPath) {
  const DerivedBlock derived(GetParam(), 1);
  const Block& block = derived.block;
  const Eigen::MatrixXd& psi = derived.psi;
  const Modes& modes = derived.modes;
  const Eigen::MatrixXd curve =
      expand_to_vertices(block.map, block.local, derived.derivatives.vectors());
  const auto deviation = [&](double p, bool curved) {
    Field u = psi.col(0) * p;
    if (curved) u += 0.5 * p * p * curve.col(0);
    Field force = internal_force(block.solid, u);
    Field linear = Field::Zero(force.size());
    const Columns k_psi = multiply(block.matrices.stiffness.get(), modes.vectors);
    linear = expand_to_vertices(block.map, block.local, k_psi).col(0) * p;
    for (VertexId v : block.fixed) force.segment<3>(3 * Eigen::Index{v}).setZero();
    return (force - linear).norm();
  };
  const double p = 1e-3;
  EXPECT_NEAR(deviation(p, false) / deviation(p / 2, false), 4.0, 0.2);  // second order without
  EXPECT_NEAR(deviation(p, true) / deviation(p / 2, true), 8.0, 0.4);    // third order with
}

// Along u(p) = Psi p + 1/2 Phi pp + 1/6 Xi ppp the static force stays K Psi p to third order, in
// every direction p of the leading modes.
TEST_P(BlockDerivatives, OfThirdOrderFollowTheStaticPath) {
  constexpr int kModes = 3;
  DerivedBlock derived(GetParam(), kModes);
  const Block& block = derived.block;
  add_third_derivatives(
      {block.solid, block.map, block.local, derived.solved.pencil, *derived.solved.solver},
      derived.psi, kModes, derived.derivatives);
  EXPECT_LE(derived.derivatives.residual, 1e-9);
  const Columns& columns = derived.derivatives.columns;
  const auto orders = third_orders_of(kModes, columns.cols());
  ASSERT_EQ(orders.size(), 10u);
  const Eigen::MatrixXd rows = expand_to_vertices(block.map, block.local, columns);
  const Columns k_psi = multiply(block.matrices.stiffness.get(), derived.modes.vectors);
  const Eigen::MatrixXd linear = expand_to_vertices(block.map, block.local, k_psi);
  const Eigen::Vector3d direction(1.0, -0.6, 0.4);
  const auto deviation = [&](double scale, bool third) {
    const Eigen::Vector3d p = scale * direction;
    Field u = rows.leftCols(kModes) * p;
    for (int j = 0; j < kModes; ++j)
      for (int i = 0; i <= j; ++i)
        u += (i == j ? 0.5 : 1.0) * p[i] * p[j] *
             rows.col(kModes + static_cast<Eigen::Index>(pair_index(i, j)));
    for (std::size_t n = 0; third && n < orders.size(); ++n) {
      const auto [i, j, l] = orders[n];
      const double often = i == l ? 1.0 / 6.0 : i == j || j == l ? 0.5 : 1.0;
      u += often * p[i] * p[j] * p[l] * rows.col(rows.cols() - 10 + static_cast<Eigen::Index>(n));
    }
    Field force = internal_force(block.solid, u);
    for (VertexId v : block.fixed) force.segment<3>(3 * Eigen::Index{v}).setZero();
    return (force - linear * p).norm();
  };
  const double p = 2e-3;
  EXPECT_NEAR(deviation(p, false) / deviation(p / 2, false), 8.0, 0.4);  // third order without
  EXPECT_NEAR(deviation(p, true) / deviation(p / 2, true), 16.0, 0.8);   // fourth order with
}

TEST(ThirdDerivatives, AreAlongTheModesThatAreAsSoftAsTheFirst) {
  EXPECT_EQ(leading_modes(Eigen::Vector3d(1.0, 1.4, 1.5)), 1);
  EXPECT_EQ(leading_modes(Eigen::Vector4d(1.0, 1.0, 1.04, 1.3)), 3);
  EXPECT_EQ(third_orders(4, 1).size(), 4u);
  EXPECT_EQ(third_orders(4, 2).size(), 4u + 2u * 3u);
  EXPECT_TRUE(third_orders_of(4, 4 + 10).empty());
  EXPECT_EQ(third_orders_of(4, 4 + 10 + 10).size(), 10u);
}

TEST(FreeDerivatives, OfAFreeBodyBalanceTheirLoadAndHoldNoRigidMotion) {
  const Block block = free_block();
  const Columns rigid = block.rigid();
  SolvedPencil solved(block.matrices, rigid, kFreeShift);
  const Modes modes = solved.modes(3);
  const Eigen::MatrixXd psi = expand_to_vertices(block.map, block.local, modes.vectors);
  const Columns phi =
      modal_derivatives(block.solid, block.local, solved.pencil, *solved.solver, modes.vectors, psi)
          .vectors();
  const Columns mass_phi = multiply(block.matrices.mass.get(), phi);
  EXPECT_LE((rigid.transpose() * mass_phi).cwiseAbs().maxCoeff(),
            1e-10 * std::sqrt((phi.transpose() * mass_phi).diagonal().maxCoeff()));
  const Columns left = multiply(block.matrices.stiffness.get(), phi);
  const Columns mass_rigid = multiply(block.matrices.mass.get(), rigid);
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      Eigen::VectorXd h = second_derivative(block, psi, i, j);
      h -= mass_rigid * (rigid.transpose() * h);
      EXPECT_LE((left.col(pair_index(i, j)) + h).norm(), 1e-8 * h.norm());
    }
}

Basis make_sample_basis(const Block& block, int r) {
  SolvedPencil solved(block.matrices, 2);
  const Modes modes = solved.modes(5);
  const Eigen::MatrixXd psi = expand_to_vertices(block.map, block.local, modes.vectors);
  ModalDerivatives derivatives = modal_derivatives(block.solid, block.local, solved.pencil,
                                                   *solved.solver, modes.vectors, psi);
  return make_basis(block.matrices, std::move(derivatives.columns), modes.squared_frequencies, 0.05,
                    {r, 2});
}

TEST(Basis, IsOrthonormalInTheMassAndDiagonalInTheStiffness) {
  for (MassKind mass : {MassKind::kConsistent, MassKind::kLumped}) {
    const Block block = clamped_block(mass);
    for (int r : {1, 12, 20}) {
      const Basis basis = make_sample_basis(block, r);
      const Eigen::MatrixXd gram =
          basis.vectors.transpose() * multiply(block.matrices.mass.get(), basis.vectors);
      EXPECT_LE((gram - Eigen::MatrixXd::Identity(r, r)).cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_LE(basis.orthonormality_error, 1e-10);
      EXPECT_LE(basis.diagonality_error, 1e-10);
      for (int i = 1; i < r; ++i) EXPECT_GE(basis.lambda[i], basis.lambda[i - 1]);
    }
  }
}

TEST(Basis, KeepsTheFirstModeAndTheSingularValuesDescend) {
  const Block block = clamped_block();
  SolvedPencil solved(block.matrices, 2);
  const Modes modes = solved.modes(5);
  const Basis basis = make_sample_basis(block, 15);
  EXPECT_EQ(basis.singular_values.size(), 20u);
  for (std::size_t i = 1; i < basis.singular_values.size(); ++i)
    EXPECT_LE(basis.singular_values[i], basis.singular_values[i - 1]);
  // Ritz values lie above the exact ones; the cut costs the first mode next to nothing.
  EXPECT_GE(basis.lambda[0], modes.squared_frequencies[0] * (1 - 1e-10));
  EXPECT_LE(basis.lambda[0], modes.squared_frequencies[0] * 1.001);
}

// More columns than rows, many of them the same motion: what a hundred modes of a small mesh give.
TEST(Basis, OfManyColumnsIsTheSameSpanAndIsHeardOfOnTheWay) {
  const DerivedBlock derived(1, 40);
  const Block& block = derived.block;
  [[maybe_unused]] const Modes& modes = derived.modes;
  const Columns& input = derived.derivatives.columns;
  ASSERT_GE(input.cols(), kLarge);
  ASSERT_GT(input.cols(), input.rows());
  std::vector<std::string> heard;
  PrincipalColumns principal =
      principal_columns(block.matrices, input, modes.squared_frequencies, 0.05, 2,
                        [&heard](const std::string& line) { heard.push_back(line); });
  EXPECT_GE(heard.size(), 4u);
  EXPECT_LE(principal.size(), input.rows());
  const Columns all = principal.first(principal.size());
  const Columns heavy = multiply(block.matrices.mass.get(), all);
  const auto size = principal.size();
  EXPECT_LE((all.transpose() * heavy - Eigen::MatrixXd::Identity(size, size)).cwiseAbs().maxCoeff(),
            1e-10);
  // Each column is held to what a Gram matrix of unit columns resolves, 1e-6.
  const Columns off = input - all * (heavy.transpose() * input);
  EXPECT_LE((off.colwise().norm().array() / input.colwise().norm().array()).maxCoeff(), 1e-5);
  // The singular values are those of the weighted columns, by another method: an eigenvalue
  // problem.
  Eigen::VectorXd weight(input.cols());
  const Eigen::VectorXd& w2 = modes.squared_frequencies;
  const Eigen::Index k = w2.size();
  weight.head(k) = w2[0] * w2.cwiseInverse();
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i)
      weight[k + static_cast<Eigen::Index>(pair_index(i, j))] =
          0.5 * 0.05 * w2[0] * w2[0] / (w2[i] * w2[j]);
  const Columns weighted = input * weight.asDiagonal();
  const Eigen::MatrixXd gram = weighted.transpose() * multiply(block.matrices.mass.get(), weighted);
  const Eigen::VectorXd squares =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .reverse();
  for (Eigen::Index i = 0; i < 12; ++i)
    EXPECT_NEAR(principal.singular_values[i], std::sqrt(squares[i]),
                1e-9 * principal.singular_values[0]);
}

// The columns of keep_always() are in every basis, for any cut; the rest is the same span as
// without them.
TEST(Basis, WhatIsKeptIsInTheSpanOfEveryCutAndTheWholeSpanStays) {
  const DerivedBlock derived(1, 4);
  const Block& block = derived.block;
  [[maybe_unused]] const Modes& modes = derived.modes;
  const Columns& input = derived.derivatives.columns;
  Columns vectors = Columns::Random(input.rows(), 2);
  vectors.col(1) *= 1e-6;
  const auto left_by = [&](const Columns& basis, const Columns& x) {
    const Columns heavy = multiply(block.matrices.mass.get(), basis);
    const Columns off = x - basis * (heavy.transpose() * x);
    return (off.colwise().norm().array() / x.colwise().norm().array()).maxCoeff();
  };
  for (int r : {3, 9, 16}) {
    PrincipalColumns principal =
        principal_columns(block.matrices, input, modes.squared_frequencies, 0.05, 2);
    keep_always(block.matrices, vectors, 2, principal);
    EXPECT_EQ(principal.size(), 16);
    const Columns first = principal.first(r);
    const Eigen::MatrixXd gram = first.transpose() * multiply(block.matrices.mass.get(), first);
    EXPECT_LE((gram - Eigen::MatrixXd::Identity(r, r)).cwiseAbs().maxCoeff(), 1e-10);
    const Basis basis = make_basis(block.matrices, std::move(principal), {r, 1});
    EXPECT_LE(basis.orthonormality_error, 1e-10);
    EXPECT_LE(left_by(basis.vectors, vectors), 1e-9);
    EXPECT_LE(left_by(basis.vectors, first), 1e-9);  // the cut is a prefix
    if (r == 16) {
      EXPECT_LE(left_by(basis.vectors, input), 1e-8);
    }
  }
}

TEST(Basis, MoreCoordinatesThanColumnsAreRefused) {
  const Block block = clamped_block();
  EXPECT_THROW(make_sample_basis(block, 21), Failure);
}

TEST(Coefficients, ThePolynomialIsTheProjectedForceOfTheFullMesh) {
  const Block block = clamped_block();
  const Basis basis = make_sample_basis(block, 12);
  const BasisRows rows = expand_to_vertices(block.map, block.local, basis.vectors);
  const Coefficients c =
      coefficients_from_gram(strain_gram(block.solid, rows, 0, block.solid.elements.size(), 2), 12);
  const double size = bounding_box(block.mesh.vertices).diagonal();
  for (double reach : {1e-3, 0.05, 0.5})
    EXPECT_LE(polynomial_error(block.solid, block.solid.elements.size(), rows, basis.lambda,
                               c.cubic, c.quartic, reach * size),
              1e-12)
        << reach;
  EXPECT_LE((c.quadratic - Eigen::MatrixXd(basis.lambda.asDiagonal())).cwiseAbs().maxCoeff(),
            1e-10 * basis.lambda.maxCoeff());
}

TEST(Coefficients, TheSumDoesNotDependOnTheThreads) {
  const Block block = clamped_block();
  const Basis basis = make_sample_basis(block, 6);
  const BasisRows rows = expand_to_vertices(block.map, block.local, basis.vectors);
  const std::size_t m = block.solid.elements.size();
  const Eigen::MatrixXd one = strain_gram(block.solid, rows, 0, m, 1);
  EXPECT_EQ(one, strain_gram(block.solid, rows, 0, m, 3));
  // Ranks add their parts.
  const Eigen::MatrixXd parts =
      strain_gram(block.solid, rows, 0, m / 3, 1) + strain_gram(block.solid, rows, m / 3, m, 1);
  EXPECT_LE((one - parts).cwiseAbs().maxCoeff(), 1e-13 * one.cwiseAbs().maxCoeff());
}

TEST(Signs, TheFirstLargeEntryIsPositiveWhateverTheSolverGave) {
  const Block block = clamped_block();
  SolvedPencil solved(block.matrices, 2);
  const Modes modes = solved.modes(4);
  Columns vectors = modes.vectors;
  BasisRows expanded = expand_to_vertices(block.map, block.local, vectors);
  Columns mirrored = -vectors;
  BasisRows mirrored_expanded = -expanded;
  fix_signs(block.local, vectors, expanded);
  fix_signs(block.local, mirrored, mirrored_expanded);
  EXPECT_EQ(vectors, mirrored);
  EXPECT_EQ(expanded, mirrored_expanded);
}

}  // namespace
}  // namespace tremolo
