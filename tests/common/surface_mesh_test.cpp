#include "common/mesh/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "common/mesh/creases.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

double enclosed_volume(const TetMesh& mesh, const BoundarySurface& surface) {
  double volume = 0;
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[surface.vertex_ids[t[0]]];
    const Eigen::Vector3d& b = mesh.vertices[surface.vertex_ids[t[1]]];
    const Eigen::Vector3d& c = mesh.vertices[surface.vertex_ids[t[2]]];
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

double sum_of_volumes(const TetMesh& mesh) {
  double volume = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) volume += signed_volume(mesh, tet);
  return volume;
}

TEST(BoundarySurface, IsClosedAndConsistentlyOriented) {
  const BoundarySurface surface = boundary_surface(testing::box_mesh({3, 2, 2}, {3, 2, 2}));
  std::map<std::pair<VertexId, VertexId>, int> directed;
  for (const Triangle& t : surface.triangles)
    for (int corner = 0; corner < 3; ++corner) ++directed[{t[corner], t[(corner + 1) % 3]}];
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1) << edge.first << "-" << edge.second;
    EXPECT_EQ(directed.count({edge.second, edge.first}), 1u) << edge.first << "-" << edge.second;
  }
}

TEST(BoundarySurface, EnclosesTheVolumeOfTheTetrahedra) {
  TetMesh mesh = testing::box_mesh({3, 2, 2}, {3, 2, 2});
  for (Eigen::Vector3d& x : mesh.vertices)
    x += 0.2 * Eigen::Vector3d(std::sin(x.y()), std::sin(x.z()), std::sin(x.x() + x.y()));
  const double expected = sum_of_volumes(mesh);
  // Some hundred products of numbers below 30 round at 1e-16 each.
  EXPECT_NEAR(enclosed_volume(mesh, boundary_surface(mesh)), expected, 1e-12);
  EXPECT_GT(expected, 0);
}

TEST(BoundarySurface, OfABoxHasTwoTrianglesASquare) {
  const TetMesh mesh = testing::box_mesh({4, 3, 2}, {4, 3, 2});
  const BoundarySurface surface = boundary_surface(mesh);
  EXPECT_EQ(surface.triangles.size(), 2u * 2u * (4 * 3 + 3 * 2 + 2 * 4));
  // All grid points but the 3 x 2 x 1 inside.
  EXPECT_EQ(surface.vertex_ids.size(), mesh.vertices.size() - 3 * 2 * 1);
  EXPECT_TRUE(std::is_sorted(surface.vertex_ids.begin(), surface.vertex_ids.end()));
}

TEST(BoundarySurface, OfOneTetrahedronIsItsFourFacesSeenFromOutside) {
  TetMesh mesh;
  // Away from the origin, or the faces through it would say nothing about their orientation.
  mesh.vertices = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}, {1, 2, 4}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  const BoundarySurface surface = boundary_surface(mesh);
  EXPECT_EQ(surface.triangles.size(), 4u);
  const Eigen::Vector3d centre(1.25, 2.25, 3.25);
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    const Eigen::Vector3d normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    EXPECT_GT(normal.dot(a - centre), 0) << t[0] << t[1] << t[2];
  }
  // A dozen products of small integers: exact except for the division by six.
  EXPECT_NEAR(enclosed_volume(mesh, surface), 1.0 / 6.0, 1e-14);
}

TEST(BoundarySurface, LeavesUnreferencedVerticesOut) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  mesh.vertices.insert(mesh.vertices.begin(), Eigen::Vector3d(9, 9, 9));
  for (Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId& v : tet) ++v;
  const BoundarySurface surface = boundary_surface(mesh);
  EXPECT_EQ(surface.vertex_ids, (std::vector<VertexId>{1, 2, 3, 4, 5, 6, 7, 8}));
}

// A corner of a cube has three sides, a vertex of a flat or bent sheet one.
TEST(Creases, ABoxIsSplitAtItsEdgesAndABentSheetIsNot) {
  const TetMesh mesh = testing::box_mesh({2, 2, 2}, {1, 1, 1});
  const BoundarySurface box = boundary_surface(mesh);
  std::vector<Eigen::Vector3d> vertices;
  for (const VertexId v : box.vertex_ids) vertices.push_back(mesh.vertices[v]);
  const CreasedSurface creased = split_at_creases(vertices, box.triangles);
  // Nine points on each of six faces.
  ASSERT_EQ(creased.vertex_of.size(), 54U);
  ASSERT_EQ(creased.triangles.size(), box.triangles.size());
  for (std::size_t v = 0; v < vertices.size(); ++v)
    EXPECT_EQ(creased.vertex_of[v], static_cast<VertexId>(v));
  for (std::size_t t = 0; t < box.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(creased.vertex_of[creased.triangles[t][k]], box.triangles[t][k]);

  const std::vector<Eigen::Vector3d> roof = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0.3}, {-1, 0, 0.3}};
  const std::vector<Triangle> gentle = {{0, 2, 1}, {0, 1, 3}};
  EXPECT_EQ(split_at_creases(roof, gentle).vertex_of.size(), 4U);
  const std::vector<Eigen::Vector3d> steep = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0.5}, {-1, 0, 0.5}};
  EXPECT_EQ(split_at_creases(steep, gentle).vertex_of.size(), 6U);
}

// Two faces at a right angle with a seam through one of them, where its vertices are double.
TEST(Creases, ASeamSplitsNoNormalAndASharpEdgeDoes) {
  const std::vector<Eigen::Vector3d> vertices = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0},
                                                 {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {0, 0, -1}};
  const std::vector<Triangle> triangles = {{0, 2, 1}, {1, 2, 3}, {4, 6, 5}, {0, 1, 7}};
  const std::vector<std::uint32_t> points = {0, 1, 2, 3, 2, 3, 4, 5};
  const CreasedSurface creased = split_at_creases(vertices, triangles, points);
  // The two of the edge between the faces have copies.
  ASSERT_EQ(creased.vertex_of.size(), vertices.size() + 2);
  EXPECT_EQ(creased.side_of[2], creased.side_of[4]);
  EXPECT_EQ(creased.side_of[3], creased.side_of[5]);
  EXPECT_EQ(creased.sharp[creased.side_of[2]], 0);
  for (const std::size_t v : {0U, 1U, 8U, 9U}) EXPECT_EQ(creased.sharp[creased.side_of[v]], 1) << v;
  EXPECT_NE(creased.side_of[0], creased.side_of[8]);
  // Without the points each vertex has its own.
  const CreasedSurface apart = split_at_creases(vertices, triangles);
  EXPECT_NE(apart.side_of[2], apart.side_of[4]);
}

}  // namespace
}  // namespace tremolo
