#include "common/mesh/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

// The error's text must hold all of these.
void expect_refused(TetMesh mesh, std::initializer_list<const char*> parts) {
  const std::vector<Tetrahedron> before = mesh.tetrahedra;
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, ErrorKind::kContent);
  for (const char* part : parts)
    EXPECT_NE(report.error().message.find(part), std::string::npos) << report.error().message;
  EXPECT_EQ(mesh.tetrahedra, before);
}

TEST(MeshCheck, AGoodMeshIsLeftAlone) {
  TetMesh mesh = testing::box_mesh({3, 2, 1}, {3, 2, 1});
  const std::vector<Tetrahedron> before = mesh.tetrahedra;
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(mesh.tetrahedra, before);
  EXPECT_EQ(report->flipped, 0u);
  EXPECT_EQ(report->unreferenced_vertices, 0u);
  EXPECT_EQ(report->parts, 1u);
  EXPECT_TRUE(report->notes.empty());
  // 36 sixths: rounding of a sixth, 36 times.
  EXPECT_NEAR(report->volume, 6.0, 1e-14);
}

TEST(MeshCheck, InvertedTetrahedraAreRepairedAndCounted) {
  TetMesh mesh = testing::box_mesh({2, 2, 2}, {2, 2, 2});
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); t += 3)
    std::swap(mesh.tetrahedra[t][0], mesh.tetrahedra[t][2]);
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->flipped, 16u);
  for (const Tetrahedron& tet : mesh.tetrahedra) EXPECT_GT(signed_volume(mesh, tet), 0);
  ASSERT_EQ(report->notes.size(), 1u);
  EXPECT_NE(report->notes[0].find("16"), std::string::npos);
}

// A vertex that moved through the opposite faces of its tetrahedra: turned by their numbers, these
// would cover the others, and the volume would be more than the box's.
TEST(MeshCheck, AFoldedMeshIsNotRepaired) {
  TetMesh mesh = testing::box_mesh({4, 2, 2}, {4, 2, 2});
  const auto inner =
      std::find(mesh.vertices.begin(), mesh.vertices.end(), Eigen::Vector3d(2, 1, 1));
  ASSERT_NE(inner, mesh.vertices.end());
  *inner = Eigen::Vector3d(3.2, 1.1, 1.05);
  double covered = 0;
  std::size_t inverted = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    covered += std::abs(signed_volume(mesh, tet));
    inverted += signed_volume(mesh, tet) < 0;
  }
  EXPECT_GT(covered, 16.2);
  EXPECT_GT(inverted, 0u);
  expect_refused(mesh, {"folded", "tetrahedra"});

  // Wrong numbering of some besides does not hide it, and of all changes nothing.
  std::swap(mesh.tetrahedra[0][0], mesh.tetrahedra[0][1]);
  expect_refused(mesh, {"folded"});
  TetMesh mirrored = testing::box_mesh({4, 2, 2}, {4, 2, 2});
  for (Tetrahedron& tet : mirrored.tetrahedra) std::swap(tet[0], tet[1]);
  EXPECT_TRUE(check_mesh(mirrored));
}

TEST(MeshCheck, RepairKeepsTheVerticesOfATetrahedron) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  std::swap(mesh.tetrahedra[4][1], mesh.tetrahedra[4][2]);
  Tetrahedron before = mesh.tetrahedra[4];
  ASSERT_TRUE(check_mesh(mesh));
  Tetrahedron after = mesh.tetrahedra[4];
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(after, before);
}

TEST(MeshCheck, AMeshWithoutTetrahedraIsRefused) {
  TetMesh mesh;
  expect_refused(mesh, {"no tetrahedra"});
  mesh.vertices = {{0, 0, 0}};
  expect_refused(mesh, {"no tetrahedra"});
}

TEST(MeshCheck, CoordinatesThatAreNotFiniteAreNamed) {
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
    mesh.vertices[3].y() = bad;
    expect_refused(mesh, {"not finite", "vertex 3"});
  }
}

TEST(MeshCheck, IndicesOutOfRangeAreNamed) {
  for (VertexId bad : {-1, 8, std::numeric_limits<VertexId>::max()}) {
    TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
    mesh.tetrahedra[2][1] = bad;
    expect_refused(mesh, {"out of range", "tetrahedron 2", std::to_string(bad).c_str(), "8"});
  }
}

TEST(MeshCheck, IndicesOutOfRangeInASetAreNamed) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  mesh.node_sets["foot"] = {0, 8};
  expect_refused(mesh, {"`foot`", "vertex 8"});
}

TEST(MeshCheck, ARepeatedVertexIsNamed) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  mesh.tetrahedra[5][3] = mesh.tetrahedra[5][0];
  expect_refused(mesh, {"repeated", "tetrahedron 5"});
}

TEST(MeshCheck, FlatTetrahedraAreNamedAtEveryScale) {
  for (double scale : {1e-6, 1.0, 1e6}) {
    TetMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.4, 1e-13}};
    mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}};
    for (Eigen::Vector3d& x : mesh.vertices) x *= scale;
    expect_refused(mesh, {"degenerate", "tetrahedron 1"});
    // Three orders thicker is a bad element but no degenerate one.
    mesh.vertices[4].z() = 1e-10 * scale;
    EXPECT_TRUE(check_mesh(mesh)) << scale;
  }
}

TEST(MeshCheck, CoincidentVerticesMakeADegenerateTetrahedron) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  for (Eigen::Vector3d& x : mesh.vertices) x.setZero();
  expect_refused(mesh, {"degenerate", "tetrahedra 0, 1, 2, 3, 4 and 1 more"});
}

TEST(MeshCheck, VolumesThatOverflowAreRefused) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  for (Eigen::Vector3d& x : mesh.vertices) x *= 1e200;
  expect_refused(mesh, {"degenerate"});
  // The volume overflows, 1e-15 of it does not.
  mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  for (Eigen::Vector3d& x : mesh.vertices) x *= 1e104;
  expect_refused(mesh, {"degenerate"});
  // Each is finite, their sum is not.
  mesh = testing::box_mesh({3, 1, 1}, {3, 1, 1});
  for (Eigen::Vector3d& x : mesh.vertices) x *= std::cbrt(1e308);
  expect_refused(mesh, {"volume of the mesh"});
}

TEST(MeshCheck, DuplicatesInAnyOrderOfVerticesAreNamed) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  Tetrahedron copy = mesh.tetrahedra[2];
  do {
    TetMesh doubled = mesh;
    doubled.tetrahedra.push_back(copy);
    expect_refused(doubled, {"duplicate", "tetrahedron 6 (same vertices as 2)"});
    std::next_permutation(copy.begin(), copy.end());
  } while (copy != mesh.tetrahedra[2]);
}

TEST(MeshCheck, UnreferencedVerticesAreKeptAndReported) {
  TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  mesh.vertices.emplace_back(5, 5, 5);
  mesh.vertices.emplace_back(6, 5, 5);
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(mesh.vertices.size(), 10u);
  EXPECT_EQ(report->unreferenced_vertices, 2u);
  EXPECT_EQ(report->part_of_vertex[8], -1);
  EXPECT_EQ(report->part_of_vertex[7], 0);
  ASSERT_EQ(report->notes.size(), 1u);
}

TEST(MeshCheck, PartsThatShareNoVertexAreLabelledApart) {
  TetMesh mesh = testing::box_mesh({2, 1, 1}, {2, 1, 1});
  const auto offset = static_cast<VertexId>(mesh.vertices.size());
  const TetMesh other = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  for (const Eigen::Vector3d& x : other.vertices)
    mesh.vertices.emplace_back(x + Eigen::Vector3d(5, 0, 0));
  // In front, so that the order of tetrahedra cannot be the order of parts.
  for (Tetrahedron tet : other.tetrahedra) {
    for (VertexId& v : tet) v += offset;
    mesh.tetrahedra.insert(mesh.tetrahedra.begin(), tet);
  }
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->parts, 2u);
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v)
    EXPECT_EQ(report->part_of_vertex[v], v < offset ? 0 : 1);
}

TEST(MeshCheck, PartsThatTouchInOneVertexAreOne) {
  TetMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  mesh.tetrahedra = {{4, 5, 6, 0}, {0, 1, 2, 3}};
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->parts, 1u);
}

}  // namespace
}  // namespace tremolo
