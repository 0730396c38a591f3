// Elements across walls, and how much too high they make frequencies.
#include "precompute/problem/wall_layers.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "precompute/problem/element_order.h"
#include "precompute/problem/material_rules.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::vertices_on_plane;

Problem problem_of(const TetMesh& mesh, double poisson) {
  Problem problem;
  problem.mesh = mesh;
  problem.report = *check_mesh(problem.mesh);
  problem.materials = *assign_materials({}, {1e6, poisson, 1000.0}, problem.mesh, {});
  return problem;
}

// The lowest frequency of a bar clamped at x = 0, Hz.
double first_frequency(const TetMesh& mesh, double poisson) {
  const DofMap map = make_dof_map(mesh, vertices_on_plane(mesh, 0, 0.0), 1);
  const LocalDofs local = local_dofs(mesh, map, 0);
  const Solid solid = make_solid(mesh, {1e6, poisson, 1000.0});
  const Matrices matrices = assemble(solid, map, local, MassKind::kConsistent);
  const Modes modes = testing::SolvedPencil(matrices).modes(1);
  return std::sqrt(modes.squared_frequencies[0]) / (2.0 * std::numbers::pi);
}

TEST(WallLayers, AreTheCellsAcrossAPlate) {
  for (const int layers : {1, 2, 5}) {
    const auto walls = find_wall_layers(box_mesh({12, 9, layers}, {1.2, 0.9, 0.02}));
    ASSERT_TRUE(walls);
    // A fraction of the narrow sides' lines is as long as the plate: they are no thin wall.
    EXPECT_NEAR(walls->thickness, 0.02, 1e-12);
    EXPECT_NEAR(walls->layers, layers, 1e-9);
    EXPECT_NEAR(walls->edge, 0.1 * std::numbers::sqrt2 / 0.02, 0.3);
  }
}

TEST(WallLayers, DoNotDependOnWhatThickPartsThereAre) {
  // A plate of one layer next to a far coarser block: the thin wall is reported.
  TetMesh mesh = box_mesh({10, 10, 1}, {1.0, 1.0, 0.01});
  const TetMesh block = box_mesh({3, 3, 3}, {0.5, 0.5, 0.5});
  const auto offset = static_cast<VertexId>(mesh.vertices.size());
  for (const Eigen::Vector3d& x : block.vertices) mesh.vertices.emplace_back(x.array() + 2.0);
  for (Tetrahedron tet : block.tetrahedra) {
    for (VertexId& v : tet) v += offset;
    mesh.tetrahedra.push_back(tet);
  }
  const auto walls = find_wall_layers(mesh);
  ASSERT_TRUE(walls);
  EXPECT_NEAR(walls->thickness, 0.01, 1e-12);
  EXPECT_NEAR(walls->layers, 1.0, 1e-9);
}

TEST(WallLayers, AWedgeThatEndsInAnEdgeHasNone) {
  TetMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  one.tetrahedra = {{0, 1, 2, 3}};
  EXPECT_FALSE(find_wall_layers(one));
}

// Bars whose frequency is known for any Poisson's ratio: too high, by the reported amount to a
// factor of 2.2.
TEST(WallLayers, TellTheErrorOfTheFrequencyToAFactorOfTwo) {
  const double length = 1.0, side = 0.05;
  const double exact = 1.8751 * 1.8751 / (2.0 * std::numbers::pi) *
                       std::sqrt(1e6 * side * side / 12.0 / 1000.0) / (length * length);
  for (const int layers : {1, 2, 4})
    for (const double poisson : {0.0, 0.3, 0.45, 0.49}) {
      const TetMesh mesh = box_mesh({20 * layers, layers, layers}, {length, side, side});
      const Locking locking = find_locking(problem_of(mesh, poisson));
      ASSERT_TRUE(locking.excess);
      const double excess = first_frequency(mesh, poisson) / exact - 1.0;
      EXPECT_LE(*locking.excess, 2.2 * excess) << layers << " layers, nu " << poisson;
      EXPECT_GE(*locking.excess, excess / 2.2) << layers << " layers, nu " << poisson;
    }
}

TEST(WallLayers, AreToldWhereTheyMatterAndNotWhereTheyDoNot) {
  const std::vector<std::string> thin =
      describe(find_locking(problem_of(box_mesh({10, 10, 1}, {0.4, 0.4, 0.01}), 0.3)));
  ASSERT_EQ(thin.size(), 1u);
  EXPECT_EQ(thin[0].rfind("warning: ", 0), 0u) << thin[0];
  EXPECT_NE(thin[0].find("0.01 m, are 1 layers"), std::string::npos) << thin[0];
  EXPECT_NE(thin[0].find("too high, by about"), std::string::npos) << thin[0];
  EXPECT_EQ(thin[0].find("hardly be compressed"), std::string::npos) << thin[0];
  const TetMesh fine = box_mesh({12, 12, 12}, {0.1, 0.1, 0.1});
  EXPECT_TRUE(describe(find_locking(problem_of(fine, 0.3))).empty());
  const std::vector<std::string> locks = describe(find_locking(problem_of(fine, 0.499)));
  ASSERT_EQ(locks.size(), 1u);
  EXPECT_NE(locks[0].find("nu is 0.499"), std::string::npos) << locks[0];
  EXPECT_NE(locks[0].find("lock that can hardly be compressed"), std::string::npos) << locks[0];
}

// More than kMostAutomaticQuadratic tetrahedra each.
TEST(WallLayers, OneLayerIsQuadraticHoweverManyElementsThereAre) {
  const auto prepared = [](const TetMesh& mesh, std::optional<int> order, int refine = 0) {
    Problem problem = problem_of(mesh, 0.3);
    ProblemRequest request;
    request.elements.order = order;
    request.elements.refine = refine;
    prepare_edges(request, problem);
    return problem;
  };
  const TetMesh plate = box_mesh({75, 75, 1}, {1.0, 1.0, 0.005});
  ASSERT_GT(plate.tetrahedra.size(), kMostAutomaticQuadratic);
  const Problem thin = prepared(plate, std::nullopt);
  EXPECT_EQ(thin.order, 2);
  ASSERT_EQ(thin.notes.size(), 1u);
  EXPECT_NE(thin.notes[0].find("quadratic elements, although"), std::string::npos) << thin.notes[0];
  EXPECT_EQ(prepared(plate, 1).order, 1);
  EXPECT_EQ(prepared(plate, std::nullopt, 1).order, 1) << "two layers once it is refined";
  const Problem solid = prepared(box_mesh({20, 20, 20}, {1.0, 1.0, 1.0}), std::nullopt);
  EXPECT_EQ(solid.order, 1);
  ASSERT_EQ(solid.notes.size(), 1u);
  EXPECT_NE(solid.notes[0].find("linear elements, as the mesh"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
