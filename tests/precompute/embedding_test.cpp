// Weights of a surface in a tetrahedral mesh.
#include "precompute/embedding/embedding.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/mesh/surface_mesh.h"
#include "precompute/embedding/box_tree.h"
#include "precompute/embedding/closest_point.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::box_mesh;

TetMesh bar() {
  return box_mesh({8, 3, 4}, {0.8, 0.2, 0.3});
}

std::vector<Vector3d> random_points(std::size_t count, const Vector3d& low, const Vector3d& high,
                                    unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d at(uniform(engine), uniform(engine), uniform(engine));
    points.push_back(low + (high - low).cwiseProduct(at));
  }
  return points;
}

Vector3d carried(const Embedding& embedding, const TetMesh& mesh, std::size_t v,
                 const std::vector<Vector3d>& positions) {
  Vector3d x = Vector3d::Zero();
  for (int c = 0; c < 4; ++c)
    x += embedding.weights[v][c] * positions[mesh.tetrahedra[embedding.tetrahedra[v]][c]];
  return x;
}

Vector3d affine(const Vector3d& x) {
  Eigen::Matrix3d a;
  a << 1.1, 0.3, -0.2, -0.4, 0.9, 0.25, 0.1, -0.35, 1.3;
  return a * x + Vector3d(3.0, -2.0, 0.5);
}

std::vector<Vector3d> moved(const TetMesh& mesh) {
  std::vector<Vector3d> positions;
  for (const Vector3d& x : mesh.vertices) positions.push_back(affine(x));
  return positions;
}

// Weights up to 3 times coordinates of size 4: a few units in the last place of those.
constexpr double kRounding = 1e-13;

TEST(Embedding, AnAffineMotionOfTheMeshMovesEveryVertexByTheSame) {
  const TetMesh mesh = bar();
  const std::vector<Vector3d> positions = moved(mesh);
  // A tenth of a cell around the bar, and inside it.
  const auto points = random_points(4000, {-0.01, -0.01, -0.01}, {0.81, 0.21, 0.31}, 1);
  const Embedding embedding = embed(points, mesh);
  EXPECT_GT(embedding.outside, 400u);
  EXPECT_EQ(embedding.clamped, 0u);
  for (std::size_t v = 0; v < points.size(); ++v) {
    EXPECT_NEAR(embedding.weights[v].sum(), 1.0, 1e-14);
    EXPECT_LE((carried(embedding, mesh, v, mesh.vertices) - points[v]).norm(), kRounding);
    EXPECT_LE((carried(embedding, mesh, v, positions) - affine(points[v])).norm(), kRounding);
  }
}

TEST(Embedding, AVertexInsideHangsOnTheTetrahedronThatContainsIt) {
  const TetMesh mesh = bar();
  const auto points = random_points(2000, {0, 0, 0}, {0.8, 0.2, 0.3}, 2);
  const Embedding embedding = embed(points, mesh);
  EXPECT_EQ(embedding.outside, 0u);
  EXPECT_EQ(embedding.largest_distance, 0.0);
  for (std::size_t v = 0; v < points.size(); ++v) {
    EXPECT_GE(embedding.weights[v].minCoeff(), -1e-9);
    EXPECT_LE(embedding.weights[v].maxCoeff(), 1.0 + 1e-9);
  }
}

TEST(Embedding, TheMeshsOwnVerticesAreCarriedExactly) {
  const TetMesh mesh = bar();
  const Embedding embedding = embed(mesh.vertices, mesh);
  EXPECT_EQ(embedding.outside, 0u);
  const std::vector<VertexId> anchors = heaviest_vertices(embedding, mesh);
  BasisRows basis = BasisRows::Random(3 * static_cast<Eigen::Index>(mesh.vertices.size()), 5);
  const BasisRows rows = embedded_rows(embedding, mesh, basis);
  for (std::size_t v = 0; v < anchors.size(); ++v) EXPECT_EQ(anchors[v], static_cast<VertexId>(v));
  EXPECT_LE((rows - basis).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Embedding, RowsAreTheWeightsTimesTheBasis) {
  const TetMesh mesh = bar();
  const auto points = random_points(50, {-0.01, 0, 0}, {0.81, 0.2, 0.3}, 3);
  const Embedding embedding = embed(points, mesh);
  const BasisRows basis = BasisRows::Random(3 * static_cast<Eigen::Index>(mesh.vertices.size()), 4);
  const BasisRows rows = embedded_rows(embedding, mesh, basis);
  const Eigen::Vector4d q(0.3, -1.0, 2.0, 0.1);
  const Eigen::VectorXd u = basis * q;
  std::vector<Vector3d> displacements;
  for (Eigen::Index v = 0; v < u.size(); v += 3) displacements.push_back(u.segment<3>(v));
  for (std::size_t v = 0; v < points.size(); ++v)
    EXPECT_LE((rows.middleRows(3 * v, 3) * q - carried(embedding, mesh, v, displacements)).norm(),
              kRounding);
}

// Scans have vertices that no triangle uses, far from the surface.
TEST(Embedding, VerticesThatNoTriangleUsesAreNotCounted) {
  const TetMesh mesh = bar();
  RenderSurface surface;
  surface.vertices = {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.01}, {9.0, 0.0, 0.0}};
  surface.triangles = {{0, 1, 2}};
  const Embedding embedding = embed_surface(surface, mesh);
  EXPECT_EQ(embedding.weights.size(), 4u);
  EXPECT_EQ(embedding.counted, 3u);
  EXPECT_EQ(embedding.outside, 0u);
  EXPECT_EQ(embedding.clamped, 0u);
  EXPECT_EQ(embedding.largest_distance, 0.0);
  EXPECT_EQ(describe(embedding, mesh).size(), 1u);  // no warning
  EXPECT_EQ(embed(surface.vertices, mesh).outside, 1u);
}

TEST(Embedding, TheDistanceIsThatToTheBoundary) {
  const TetMesh mesh = bar();
  const Embedding embedding =
      embed({{0.4, 0.1, 0.15}, {0.4, 0.1, 0.32}, {0.9, 0.1, 0.15}, {0.83, 0.24, 0.15}}, mesh);
  EXPECT_EQ(embedding.outside, 3u);
  EXPECT_NEAR(embedding.largest_distance, 0.1, 1e-15);
}

TEST(Embedding, WhatIsTooFarOutsideFollowsTheNearestPoint) {
  const TetMesh mesh = bar();  // cells of 0.1 m
  const Embedding embedding = embed({{5.8, 0.1, 0.15}}, mesh);
  EXPECT_EQ(embedding.clamped, 1u);
  EXPECT_NEAR(embedding.clamped_distance, 5.0, 1e-12);
  EXPECT_NEAR(embedding.weights[0].sum(), 1.0, 1e-14);
  EXPECT_GE(embedding.weights[0].minCoeff(), 0.0);
  EXPECT_LE((carried(embedding, mesh, 0, mesh.vertices) - Vector3d(0.8, 0.1, 0.15)).norm(), 1e-12);
  const std::vector<std::string> notes = describe(embedding, mesh);
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_NE(notes[1].find("1 vertices are too far outside"), std::string::npos);
  EXPECT_NE(notes[2].find("--unit"), std::string::npos);
}

// No weight leaves its range, however thin the tetrahedra at the boundary.
TEST(Embedding, WeightsStayInTheirRangeInFlatTetrahedra) {
  const TetMesh mesh = box_mesh({6, 6, 40}, {1, 1, 0.2});
  const auto points = random_points(3000, {-0.3, -0.3, -0.3}, {1.3, 1.3, 0.5}, 4);
  const Embedding embedding = embed(points, mesh);
  EXPECT_GT(embedding.clamped, 100u);
  for (const Eigen::Vector4d& weights : embedding.weights) {
    EXPECT_GE(weights.minCoeff(), kLeastWeight);
    EXPECT_LE(weights.maxCoeff(), kLargestWeight);
    EXPECT_NEAR(weights.sum(), 1.0, 1e-12);
  }
}

TEST(Embedding, ThreadsDoNotChangeIt) {
  const TetMesh mesh = bar();
  const auto points = random_points(5000, {-0.1, -0.1, -0.1}, {0.9, 0.3, 0.4}, 5);
  const Embedding one = embed(points, mesh, 1), three = embed(points, mesh, 3);
  EXPECT_EQ(one.tetrahedra, three.tetrahedra);
  EXPECT_EQ(one.weights, three.weights);
  EXPECT_EQ(one.outside, three.outside);
}

TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  std::mt19937 engine(6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random = [&] { return Vector3d(uniform(engine), uniform(engine), uniform(engine)); };
  for (int trial = 0; trial < 300; ++trial) {
    std::array<Vector3d, 3> corners{random(), random(), random()};
    if (trial % 3 == 1) corners[2] = 0.3 * corners[0] + 0.7 * corners[1];  // a segment
    if (trial % 3 == 2 && trial % 2 == 0) corners[2] = corners[1] = corners[0];
    const Vector3d x = 2.0 * random();
    const ClosestPoint closest = closest_on_triangle(x, corners);
    EXPECT_GE(closest.weights.minCoeff(), 0.0);
    EXPECT_NEAR(closest.weights.sum(), 1.0, 1e-12);
    const Vector3d at = closest.weights[0] * corners[0] + closest.weights[1] * corners[1] +
                        closest.weights[2] * corners[2];
    EXPECT_NEAR((x - at).squaredNorm(), closest.squared_distance, 1e-12);
    for (int i = 0; i <= 10; ++i)
      for (int j = 0; i + j <= 10; ++j) {
        const Vector3d other =
            0.1 * i * corners[0] + 0.1 * j * corners[1] + 0.1 * (10 - i - j) * corners[2];
        EXPECT_GE((x - other).squaredNorm(), closest.squared_distance - 1e-12);
      }
  }
}

TEST(BoxTree, FindsWhatASearchThroughAllFinds) {
  const auto points = random_points(700, {0, 0, 0}, {1, 2, 3}, 7);
  std::vector<BoundingBox> boxes;
  for (const Vector3d& x : points) boxes.push_back({x, x});
  boxes.insert(boxes.end(), 30, boxes.front());  // equal ones must not go on for ever
  const BoxTree tree(boxes);
  for (const Vector3d& x : random_points(200, {-1, -1, -1}, {2, 3, 4}, 8)) {
    double expected = 1e300;
    std::size_t within = 0, found_within = 0;
    for (const BoundingBox& box : boxes) {
      expected = std::min(expected, (box.low - x).squaredNorm());
      within += (box.low - x).squaredNorm() <= 1.0;
    }
    const auto squared = [&](std::size_t item) { return (boxes[item].low - x).squaredNorm(); };
    EXPECT_EQ(tree.nearest(x, squared).squared_distance, expected);
    tree.visit_near(x, 1.0, [&](std::size_t item) { found_within += squared(item) <= 1.0; });
    EXPECT_EQ(found_within, within);
  }
  EXPECT_EQ(BoxTree({}).nearest({0, 0, 0}, [](std::size_t) { return 0.0; }).squared_distance,
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace tremolo
