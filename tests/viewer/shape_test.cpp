// The shape of a collider is where its distance is zero, is closed, and faces outwards.
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/apps/view/shape/collider_shape.h"
#include "runtime/apps/view/shape/creased_shape.h"
#include "runtime/apps/view/shape/moved_by.h"
#include "runtime/apps/view/shape/sheet_geometry.h"
#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "tests/support/meshes/small_tets.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

double volume_of(const TriangleShape& shape) {
  double volume = 0.0;
  for (std::size_t t = 0; t < shape.triangles.size(); t += 3) {
    const auto corner = [&](std::size_t k) {
      return Vector3d(shape.positions[shape.triangles[t + k]].cast<double>());
    };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volume;
}

double farthest_from(const Collider& collider, const TriangleShape& shape) {
  double farthest = 0.0;
  for (const Eigen::Vector3f& x : shape.positions)
    farthest = std::max(farthest, std::abs(signed_distance(collider, x.cast<double>()).distance));
  return farthest;
}

TEST(ColliderShape, LiesOnTheSolidAndHoldsItsVolume) {
  const double pi = std::numbers::pi;
  const std::vector<std::pair<Collider, double>> solids = {
      {SphereShape{0.7}, 4.0 / 3.0 * pi * 0.343},
      {CapsuleShape{0.3, 0.5}, pi * 0.09 * 1.0 + 4.0 / 3.0 * pi * 0.027},
      {BoxShape{{0.3, 0.5, 0.2}}, 8.0 * 0.03},
      {CylinderShape{0.4, 0.6}, pi * 0.16 * 1.2}};
  for (const auto& [solid, volume] : solids) {
    const TriangleShape shape = collider_shape(solid, 1.0);
    EXPECT_LT(farthest_from(solid, shape), 1e-6) << shape_name(solid);
    // Chords lie inside: a circle of 96 sides has 0.07 % less area.
    EXPECT_LT(volume_of(shape), volume * (1.0 + 1e-6)) << shape_name(solid);
    EXPECT_GT(volume_of(shape), volume * 0.998) << shape_name(solid);
    for (std::size_t v = 0; v < shape.positions.size(); ++v)
      EXPECT_GT(shape.normals[v].dot(shape.positions[v]), 0.0f) << shape_name(solid);
  }
}

Collider ball_on_a_grid(std::uint32_t nodes, double radius) {
  GridNodes grid;
  grid.spacing = 2.0 / (nodes - 1);
  grid.origin = Vector3d::Constant(-1.0);
  grid.counts = {nodes, nodes, nodes};
  std::vector<float> values;
  for (std::size_t k = 0; k < nodes; ++k)
    for (std::size_t j = 0; j < nodes; ++j)
      for (std::size_t i = 0; i < nodes; ++i)
        values.push_back(static_cast<float>(grid.at(i, j, k).norm() - radius));
  auto made = DistanceGrid::create(grid, values);
  EXPECT_TRUE(made);
  return GridShape{std::make_shared<const DistanceGrid>(std::move(*made))};
}

// Also for a grid so fine that only every second node is used.
TEST(ColliderShape, OfAGridIsClosedAndWhereItsDistanceIsZero) {
  for (const std::uint32_t nodes : {24U, 120U}) {
    const Collider ball = ball_on_a_grid(nodes, 0.6);
    const TriangleShape shape = collider_shape(ball, 1.0);
    EXPECT_LT(farthest_from(ball, shape), 0.004) << nodes;
    EXPECT_NEAR(volume_of(shape), 4.0 / 3.0 * std::numbers::pi * 0.216, 0.015) << nodes;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t t = 0; t < shape.triangles.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k)
        ++edges[{shape.triangles[t + k], shape.triangles[t + (k + 1) % 3]}];
    for (const auto& [edge, count] : edges) {
      ASSERT_EQ(count, 1);
      ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    }
  }
}

TEST(CreasedShape, HasSharpRimsAndSmoothSides) {
  const double radius = 0.03, half = 0.05;
  const SurfaceMesh drum = surface_of_shape(CylinderShape{radius, half}, 200);
  const TriangleShape shape = creased_shape(drum.vertices, drum.triangles);
  ASSERT_EQ(shape.triangles.size(), 3 * drum.triangles.size());
  for (std::size_t k = 0; k < shape.triangles.size(); k += 3) {
    const auto at = [&](std::size_t corner) { return shape.positions[shape.triangles[corner]]; };
    const Eigen::Vector3f face = (at(k + 1) - at(k)).cross(at(k + 2) - at(k));
    const bool cap = std::abs(face.normalized().z()) > 0.9f;
    for (std::size_t corner = k; corner < k + 3; ++corner) {
      const Eigen::Vector3f x = at(corner);
      const Eigen::Vector3f truth = cap ? Eigen::Vector3f(0.0f, 0.0f, x.z() > 0.0f ? 1.0f : -1.0f)
                                        : Eigen::Vector3f(x.x(), x.y(), 0.0f).normalized();
      EXPECT_GT(shape.normals[shape.triangles[corner]].dot(truth), cap ? 0.9999f : 0.97f)
          << x.transpose();
    }
  }
}

// A box of tetrahedra that is turned and sheared: each corner has the normal of its face.
TEST(CreasedSheet, KeepsItsEdgesSharpWhenItDeforms) {
  const TetMesh mesh = testing::box_mesh({3, 2, 2}, {0.3, 0.2, 0.2});
  const TetsSurface box = testing::drawn_boundary(mesh);
  CreasedSheet sheet(box.vertices, box.triangles);
  ASSERT_GT(sheet.vertices(), box.vertices.size());
  Eigen::Matrix3d f = Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  f.col(0) += 0.2 * f.col(1);
  std::vector<float> positions;
  for (const Vector3d& x : box.vertices)
    for (const double coordinate : Vector3d(f * x))
      positions.push_back(static_cast<float>(coordinate));
  std::vector<float> normals;
  mean_normals(box.triangles, positions, normals);
  sheet.pose(positions, normals);
  const auto at = [](const std::vector<float>& values, VertexId v) {
    return Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * static_cast<std::size_t>(v));
  };
  for (const Triangle& t : sheet.triangles()) {
    const auto& x = sheet.positions();
    const Eigen::Vector3f face = (at(x, t[1]) - at(x, t[0])).cross(at(x, t[2]) - at(x, t[0]));
    for (const VertexId v : t) EXPECT_GT(at(sheet.normals(), v).dot(face.normalized()), 0.99999f);
  }
  // Colours follow.
  std::vector<float> numbers(box.vertices.size());
  for (std::size_t v = 0; v < numbers.size(); ++v) numbers[v] = positions[3 * v];
  const std::vector<float> own = sheet.spread(numbers, 1);
  for (std::size_t v = 0; v < own.size(); ++v) EXPECT_EQ(own[v], sheet.positions()[3 * v]);
}

TEST(MovedBy, IsWhatARigidMotionLeaves) {
  const std::vector<Vector3d> rest = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.0, Vector3d(1, -1, 2).normalized()));
  std::vector<float> positions, out;
  for (const Vector3d& x : rest) {
    const Vector3d place = turn * x + Vector3d(3.0, -2.0, 1.0);
    for (const double coordinate : place) positions.push_back(static_cast<float>(coordinate));
  }
  EXPECT_EQ(moved_by(rest, positions, out), 0.0f) << "rounding is no displacement";
  EXPECT_EQ(out, std::vector<float>(4, 0.0f));
  positions[11] += 0.01f;
  const float most = moved_by(rest, positions, out);
  EXPECT_GT(most, 0.003f);
  EXPECT_EQ(most, *std::max_element(out.begin(), out.end()));
}

TEST(Images, AreRepeatedOnlyBeyondTheirEdges) {
  const std::vector<float> uvs = {0.0f, 0.0f, 1.0f, 0.0f, 1.0f, 1.00001f, 0.0f, 2.0f};
  EXPECT_FALSE(repeats_image(std::vector<std::uint32_t>{0, 1, 2}, uvs));
  EXPECT_TRUE(repeats_image(std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}, uvs));
}

}  // namespace
}  // namespace tremolo
