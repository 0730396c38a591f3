#include "common/mesh/mesh_quality.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

// A handful of operations on numbers of size 1 (angles: of size 100).
constexpr double kRounding = 1e-12;
constexpr double kAngleRounding = 1e-10;

TetMesh regular_tetrahedron() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 2, 1, 3}}, {}};
}

// The corner of a cube: three right angles and three of arctan(sqrt 2).
TetMesh corner_tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}, {}};
}

// Four points near a square's corners, lifted by +-height: no short edge, but no volume either.
TetMesh sliver(double height) {
  return {{{1, 0, height}, {0, 1, -height}, {-1, 0, height}, {0, -1, -height}}, {{0, 1, 2, 3}}, {}};
}

TEST(MeshQuality, RegularTetrahedronHasRatioOneAndSixEqualAngles) {
  const MeshQuality quality = mesh_quality(regular_tetrahedron());
  const double angle = std::acos(1.0 / 3.0) * 180.0 / std::numbers::pi;
  EXPECT_NEAR(quality.min_dihedral_deg, angle, kAngleRounding);
  EXPECT_NEAR(quality.max_dihedral_deg, angle, kAngleRounding);
  EXPECT_NEAR(quality.min_radius_ratio, 1.0, kRounding);
  EXPECT_NEAR(quality.mean_radius_ratio, 1.0, kRounding);
}

TEST(MeshQuality, CubeCornerHasItsKnownAnglesRatioAndVolume) {
  const MeshQuality quality = mesh_quality(corner_tetrahedron());
  EXPECT_NEAR(quality.min_dihedral_deg, std::atan(std::sqrt(2.0)) * 180.0 / std::numbers::pi,
              kAngleRounding);
  EXPECT_NEAR(quality.max_dihedral_deg, 90.0, kAngleRounding);
  // Radii 1 / (3 + sqrt 3) and sqrt 3 / 2.
  EXPECT_NEAR(quality.min_radius_ratio, 6.0 / ((3.0 + std::sqrt(3.0)) * std::sqrt(3.0)), kRounding);
  EXPECT_NEAR(quality.volume, 1.0 / 6.0, kRounding);
}

TEST(MeshQuality, SliverHasAnglesNearFlatAndRatioNearZero) {
  const MeshQuality quality = mesh_quality(sliver(1e-3));
  EXPECT_LT(quality.min_dihedral_deg, 0.5);
  EXPECT_GT(quality.max_dihedral_deg, 179.5);
  EXPECT_LT(quality.min_radius_ratio, 0.01);
  EXPECT_GT(quality.min_radius_ratio, 0.0);
}

TEST(MeshQuality, FlatTetrahedronHasRatioZeroAndNothingUndefined) {
  const MeshQuality quality = mesh_quality(sliver(0.0));
  EXPECT_EQ(quality.min_radius_ratio, 0.0);
  EXPECT_EQ(quality.volume, 0.0);
  EXPECT_TRUE(std::isfinite(quality.min_dihedral_deg));
}

TEST(MeshQuality, ShapeDoesNotDependOnSizePlaceOrTurn) {
  TetMesh moved = corner_tetrahedron();
  const Eigen::Matrix3d turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  for (Eigen::Vector3d& x : moved.vertices) x = 0.01 * (turn * x) + Eigen::Vector3d(3, -1, 2);
  const MeshQuality a = mesh_quality(corner_tetrahedron());
  const MeshQuality b = mesh_quality(moved);
  // Edges of 0.01 m, 3 m from the origin, lose three digits.
  EXPECT_NEAR(a.min_dihedral_deg, b.min_dihedral_deg, 1e-9);
  EXPECT_NEAR(a.min_radius_ratio, b.min_radius_ratio, 1e-10);
  EXPECT_NEAR(a.volume, b.volume * 1e6, 1e-10);
}

TEST(MeshQuality, InvertedTetrahedronKeepsItsShapeAndHasNegativeVolume) {
  TetMesh inverted = corner_tetrahedron();
  std::swap(inverted.tetrahedra[0][0], inverted.tetrahedra[0][1]);
  const MeshQuality quality = mesh_quality(inverted);
  EXPECT_NEAR(quality.min_volume, -1.0 / 6.0, kRounding);
  EXPECT_NEAR(quality.max_dihedral_deg, 90.0, kAngleRounding);
}

TEST(MeshQuality, WorstAndMeanAreOverAllTetrahedra) {
  TetMesh both = corner_tetrahedron();
  for (const Eigen::Vector3d& x : regular_tetrahedron().vertices)
    both.vertices.push_back(x + Eigen::Vector3d(10, 0, 0));
  both.tetrahedra.push_back({4, 6, 5, 7});
  const MeshQuality corner = mesh_quality(corner_tetrahedron());
  const MeshQuality quality = mesh_quality(both);
  EXPECT_NEAR(quality.min_radius_ratio, corner.min_radius_ratio, kRounding);
  EXPECT_NEAR(quality.mean_radius_ratio, 0.5 * (1.0 + corner.min_radius_ratio), kRounding);
  EXPECT_NEAR(quality.min_volume, 1.0 / 6.0, kRounding);
  EXPECT_EQ(quality.parts, 2u);
}

TEST(MeshQuality, PartsAreCountedThroughSharedVerticesOnly) {
  TetMesh mesh = corner_tetrahedron();
  mesh.vertices.emplace_back(0, 0, -1);
  mesh.vertices.emplace_back(5, 5, 5);  // belongs to nothing
  mesh.tetrahedra.push_back({0, 2, 1, 4});
  EXPECT_EQ(mesh_quality(mesh).parts, 1u);
}

TEST(MeshQuality, TwoPartsJoinedLaterAreOne) {
  // A strip of points on a twisted curve: any four of them have a volume.
  TetMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i, i * i, i * i * i);
  mesh.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}, {7, 6, 3, 2}};
  EXPECT_EQ(mesh_quality(mesh).parts, 1u);
  mesh.tetrahedra.pop_back();
  EXPECT_EQ(mesh_quality(mesh).parts, 2u);
}

TEST(MeshQuality, EmptyMeshHasNoParts) {
  EXPECT_EQ(mesh_quality({}).parts, 0u);
}

}  // namespace
}  // namespace tremolo
