// Polygons -> triangles that cover what the outline encloses.
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/mesh/surface_mesh.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Outline = std::vector<Vector3d>;

struct Cut {
  std::size_t count = 0;
  double area = 0.0;      // along the normal: a triangle that faces away counts against it
  double absolute = 0.0;  // of all triangles
};

Cut cut(const Outline& outline, const Vector3d& normal) {
  std::vector<std::array<std::size_t, 3>> triangles;
  cut_polygon(outline, triangles);
  Cut result;
  for (const auto& [a, b, c] : triangles) {
    const Vector3d twice = (outline[b] - outline[a]).cross(outline[c] - outline[a]);
    ++result.count;
    result.area += 0.5 * twice.dot(normal);
    result.absolute += 0.5 * twice.norm();
  }
  return result;
}

void expect_area(const Outline& outline, double area, const Vector3d& normal = Vector3d::UnitZ()) {
  const Cut result = cut(outline, normal);
  EXPECT_EQ(result.count, outline.size() - 2);
  EXPECT_NEAR(result.area, area, 1e-12 * std::max(1.0, area));
  // None lies outside of the outline, where another one would have to make up for it.
  EXPECT_NEAR(result.absolute, area, 1e-12 * std::max(1.0, area));
}

// Every corner may come first.
void expect_area_from_every_corner(const Outline& outline, double area) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  for (std::size_t first = 0; first < outline.size(); ++first) {
    Outline shifted, turned;
    for (std::size_t k = 0; k < outline.size(); ++k) {
      shifted.push_back(outline[(first + k) % outline.size()]);
      turned.push_back(turn * shifted.back() + Vector3d(3, 1, 2));
    }
    expect_area(shifted, area);
    // The rounding of a turned point is 1e-16 of its place, some metres.
    const Cut result = cut(turned, turn.col(2));
    EXPECT_NEAR(result.area, area, 1e-12);
    EXPECT_NEAR(result.absolute, area, 1e-12);
  }
}

TEST(PolygonCut, ConcaveOutlinesAreCoveredWhicheverCornerComesFirst) {
  expect_area_from_every_corner({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}},
                                3);
  expect_area_from_every_corner({{0, 0, 0}, {2, 2, 0}, {4, 0, 0}, {2, 5, 0}}, 6);
  Outline comb, star;
  for (int k = 0; k < 6; ++k) {
    comb.emplace_back(k, 0, 0);
    comb.emplace_back(k + 0.5, k % 2 == 0 ? 0.1 : -3.0, 0);
  }
  comb.emplace_back(6, 0, 0);
  comb.emplace_back(6, 1, 0);
  comb.emplace_back(0, 1, 0);
  // Below y = 0 three teeth of area 1.5, above the strip of 6 without three dents of 0.05.
  expect_area_from_every_corner(comb, 6 + 3 * 1.5 - 3 * 0.05);
  for (int k = 0; k < 10; ++k) {
    const double angle = std::numbers::pi * k / 5, radius = k % 2 == 0 ? 2 : 1;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  const double ten_triangles = 10 * std::sin(std::numbers::pi / 5);
  expect_area_from_every_corner(star, ten_triangles);
}

TEST(PolygonCut, CornersOnAnEdgeGiveNoFlatTriangles) {
  const Outline outline = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}};
  std::vector<std::array<std::size_t, 3>> triangles;
  cut_polygon(outline, triangles);
  ASSERT_EQ(triangles.size(), 4U);
  for (const auto& [a, b, c] : triangles)
    EXPECT_GT((outline[b] - outline[a]).cross(outline[c] - outline[a]).norm(), 0.1);
}

TEST(PolygonCut, AConvexPolygonIsAFanFromItsFirstCorner) {
  std::vector<std::array<std::size_t, 3>> triangles;
  cut_polygon(Outline{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, triangles);
  EXPECT_EQ(triangles, (std::vector<std::array<std::size_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

// A polygon around a random star-shaped curve, of many corners.
TEST(PolygonCut, RandomOutlinesAreCovered) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.2, 1.0);
  for (int round = 0; round < 200; ++round) {
    Outline outline;
    double area = 0.0;
    const int corners = 4 + round % 40;
    std::vector<double> radii;
    for (int k = 0; k < corners; ++k) radii.push_back(uniform(random));
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      outline.emplace_back(radii[k] * std::cos(angle), radii[k] * std::sin(angle), 0);
      area += 0.5 * radii[k] * radii[(k + 1) % corners] * std::sin(2 * std::numbers::pi / corners);
    }
    expect_area(outline, area);
  }
}

TEST(PolygonCut, OutlinesThatAreNoneGiveTrianglesWithoutEnd) {
  EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}}, Vector3d::UnitZ()).count, 0U);
  EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, Vector3d::UnitZ()).count, 2U);
  // A bow tie, whose area is none, and one whose halves differ.
  EXPECT_EQ(cut({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}, Vector3d::UnitZ()).count, 2U);
  EXPECT_EQ(
      cut({{0, 0, 0}, {3, 3, 0}, {3, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}}, Vector3d::UnitZ()).count, 3U);
}

}  // namespace
}  // namespace tremolo
