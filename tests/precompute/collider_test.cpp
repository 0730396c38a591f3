// Surfaces as colliders: what is inside, how far it is, and how well a grid keeps that.
#include <random>

#include <gtest/gtest.h>

#include "precompute/collider/closed_surface.h"
#include "precompute/collider/collider_grid.h"
#include "precompute/collider/surface_distance.h"
#include "precompute/collider/surface_edges.h"
#include "tests/support/distance_fields.h"
#include "tests/support/meshes/surfaces.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Result<ClosedSurface> closed_by_itself(const SurfaceMesh& surface) {
  return close_surface(testing::as_render_surface(surface), false);
}

ClosedSurface closed_surface(const SurfaceMesh& surface, bool any_hole = false) {
  Result<ClosedSurface> closed = close_surface(testing::as_render_surface(surface), any_hole);
  EXPECT_TRUE(closed) << closed.error().message;
  return closed ? std::move(*closed) : ClosedSurface{};
}

Vector3d point_around(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  const double x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

// Largest difference to the formula at random points.
double largest_difference(const SurfaceDistance& distance,
                          const testing::DistanceFormula& formula) {
  std::mt19937 random(1);
  double largest = 0.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vector3d x = point_around(random, 2.0);
    largest = std::max(largest, std::abs(distance.at(x) - formula(x)));
  }
  return largest;
}

double difference_to_box(const ClosedSurface& closed) {
  return largest_difference(SurfaceDistance(closed), testing::box_formula({0.8, 0.9, 0.7}));
}

SurfaceMesh centred_box() {
  return testing::box_surface({1.6, 1.8, 1.4}, {-0.8, -0.9, -0.7});
}

struct MadeDistances {
  GridNodes nodes;
  std::vector<float> values;
  GridError error;
};

MadeDistances distances_of(const SurfaceMesh& surface, int cells, unsigned threads = 2) {
  const SurfaceDistance distance(closed_surface(surface));
  const Result<GridNodes> nodes = plan_nodes(bounding_box(surface.vertices), cells, 0.2);
  EXPECT_TRUE(nodes);
  MadeDistances made{*nodes, distances_at_nodes(distance, *nodes, threads), {}};
  const Result<DistanceGrid> grid = DistanceGrid::create(made.nodes, made.values);
  EXPECT_TRUE(grid) << grid.error().message;
  if (grid) made.error = measure_error(distance, *grid, threads);
  return made;
}

TEST(ColliderSurface, DistanceToABoxIsThatOfItsFormula) {
  EXPECT_LT(difference_to_box(closed_surface(centred_box())), 1e-14);
}

TEST(ColliderSurface, HowItsTrianglesAreDrawnDoesNotMatter) {
  const SurfaceMesh box = centred_box();
  EXPECT_LT(difference_to_box(closed_surface(testing::reversed(box))), 1e-14);
  EXPECT_LT(difference_to_box(closed_surface(testing::soup(box))), 1e-14);
  const ClosedSurface turned = closed_surface(testing::soup(testing::turned_at_random(box, 0.3)));
  EXPECT_GT(turned.turned_triangles, 0U);
  EXPECT_LT(difference_to_box(turned), 1e-14);
  // Every triangle twice.
  EXPECT_LT(difference_to_box(closed_surface(testing::together(box, box))), 1e-14);
  const ClosedSurface back =
      closed_surface(testing::together(box, testing::box_surface({0, 0, 0}, {0, 0, 0})));
  EXPECT_LT(difference_to_box(back), 1e-14);
}

TEST(ColliderSurface, PartsThatFaceInwardsAreTurnedAndCavitiesKept) {
  const SurfaceMesh ball = testing::sphere_surface(0.4);
  const SurfaceMesh box = centred_box();
  const ClosedSurface hollow = closed_surface(testing::together(box, testing::reversed(ball)));
  EXPECT_EQ(hollow.parts, 2U);
  EXPECT_EQ(hollow.turned_parts, 0U);
  EXPECT_FALSE(SurfaceDistance(hollow).is_inside(Vector3d::Zero()));
  EXPECT_TRUE(SurfaceDistance(hollow).is_inside({0.7, 0, 0}));
  // The same, all of it inside out.
  const ClosedSurface inverted = closed_surface(testing::together(testing::reversed(box), ball));
  EXPECT_FALSE(SurfaceDistance(inverted).is_inside(Vector3d::Zero()));
  EXPECT_TRUE(SurfaceDistance(inverted).is_inside({0.7, 0, 0}));
  SurfaceMesh beside = testing::reversed(ball);
  for (Vector3d& x : beside.vertices) x.x() += 2.0;
  const ClosedSurface pair = closed_surface(testing::together(box, beside));
  EXPECT_EQ(pair.turned_parts, 1U);
  EXPECT_TRUE(SurfaceDistance(pair).is_inside({2, 0, 0}));
}

// Surfaces inside of the other part do not count: the distance is that to the outer one.
TEST(ColliderSurface, PartsInsideOfOthersAreNoBoundary) {
  const ClosedSurface nested =
      closed_surface(testing::together(centred_box(), testing::sphere_surface(0.4)));
  EXPECT_EQ(nested.buried_triangles, testing::sphere_surface(0.4).triangles.size());
  EXPECT_LT(difference_to_box(nested), 1e-14);
  const ClosedSurface crossing = closed_surface(testing::together(
      testing::box_surface({1, 1, 1}), testing::box_surface({1, 1, 1}, {0.5, 0.1, 0.2})));
  EXPECT_TRUE(SurfaceDistance(crossing).is_inside({0.75, 0.5, 0.5}));
  EXPECT_TRUE(SurfaceDistance(crossing).is_inside({1.25, 0.5, 0.5}));
  EXPECT_FALSE(SurfaceDistance(crossing).is_inside({1.25, 0.05, 0.5}));
}

TEST(ColliderSurface, SmallHolesAreClosed) {
  const SurfaceMesh holed = testing::sphere_surface(1.0, 48, 96, 0.1);
  const ClosedSurface closed = closed_surface(holed);
  EXPECT_EQ(closed.holes, 1U);
  EXPECT_NEAR(closed.largest_hole, 0.2 * std::sqrt(2.0), 0.01);
  EXPECT_TRUE(boundary_loops(closed.surface).empty());
  // The lid is up to 0.005 below the ball, and so are the facets.
  EXPECT_LT(largest_difference(SurfaceDistance(closed), testing::sphere_formula(1.0)), 0.006);
  // A few triangles are missing here and there.
  SurfaceMesh torn = testing::sphere_surface(1.0, 48, 96);
  for (std::size_t t = 500; t < 6000; t += 501)
    torn.triangles.erase(torn.triangles.begin() + static_cast<std::ptrdiff_t>(t));
  const ClosedSurface mended = closed_surface(torn);
  EXPECT_EQ(mended.holes, 11U);
  EXPECT_LT(largest_difference(SurfaceDistance(mended), testing::sphere_formula(1.0)), 0.006);
}

TEST(ColliderSurface, WhatHasNoInsideIsRefused) {
  const auto refusal = [](const SurfaceMesh& surface) {
    const Result<ClosedSurface> closed = closed_by_itself(surface);
    EXPECT_FALSE(closed);
    EXPECT_TRUE(closed || closed.error().kind == ErrorKind::kContent);
    return closed ? std::string() : closed.error().message;
  };
  EXPECT_NE(refusal(testing::plane_surface(8)).find("the surface is open"), std::string::npos);
  EXPECT_NE(refusal(testing::sphere_surface(1.0, 24, 48, 1.0)).find("the surface is open"),
            std::string::npos);
  EXPECT_NE(refusal(testing::strip_surface(1)).find("one side only"), std::string::npos);
  EXPECT_NE(refusal({}).find("no triangle"), std::string::npos);
  EXPECT_NE(refusal(testing::together(centred_box(), testing::reversed(centred_box())))
                .find("encloses no volume"),
            std::string::npos);
  const ClosedSurface bowl = closed_surface(testing::sphere_surface(1.0, 24, 48, 1.5), true);
  EXPECT_EQ(bowl.holes, 1U);
  EXPECT_TRUE(SurfaceDistance(bowl).is_inside({0, 0, -0.5}));
  EXPECT_FALSE(SurfaceDistance(bowl).is_inside({0, 0, 0.5}));
  const Result<ClosedSurface> sheet =
      close_surface(testing::as_render_surface(testing::plane_surface(8)), true);
  ASSERT_FALSE(sheet);
  EXPECT_NE(sheet.error().message.find("encloses no volume"), std::string::npos);
}

// An edge of three triangles: two boxes with a common wall, which exists once.
TEST(ColliderSurface, AWallInsideIsNoBoundary) {
  SurfaceMesh boxes = testing::box_surface({2, 1, 1});
  const auto first = static_cast<VertexId>(boxes.vertices.size());
  for (const auto& [y, z] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    boxes.vertices.push_back({1.0, static_cast<double>(y), static_cast<double>(z)});
  boxes.triangles.push_back({first, first + 1, first + 2});
  boxes.triangles.push_back({first, first + 2, first + 3});
  const ClosedSurface closed = closed_surface(boxes, true);
  EXPECT_TRUE(SurfaceDistance(closed).is_inside({0.5, 0.5, 0.5}));
  EXPECT_NEAR(SurfaceDistance(closed).at({1.01, 0.5, 0.5}), -0.5, 1e-12);
}

TEST(ColliderGrid, ValuesAreExactAtNodes) {
  const SurfaceMesh torus = testing::torus_surface(0.9, 0.35, 40, 16);
  const SurfaceDistance distance(closed_surface(torus));
  const MadeDistances made = distances_of(torus, 20);
  std::size_t at = 0, inside = 0;
  for (std::size_t k = 0; k < made.nodes.counts[2]; ++k)
    for (std::size_t j = 0; j < made.nodes.counts[1]; ++j)
      for (std::size_t i = 0; i < made.nodes.counts[0]; ++i, ++at) {
        ASSERT_EQ(made.values[at], static_cast<float>(distance.at(made.nodes.at(i, j, k))));
        inside += made.values[at] < 0.0F ? 1 : 0;
      }
  EXPECT_GT(inside, 500U);
}

TEST(ColliderGrid, DoesNotDependOnThreads) {
  const SurfaceMesh box = centred_box();
  const MadeDistances one = distances_of(box, 24, 1), three = distances_of(box, 24, 3);
  EXPECT_EQ(one.values, three.values);
  EXPECT_EQ(one.error.largest, three.error.largest);
  EXPECT_EQ(one.error.root_mean_square, three.error.root_mean_square);
}

// The kinks inside a box's edges decide: first order in the maximum.
TEST(ColliderGrid, ErrorOfABoxFallsWithTheCells) {
  const MadeDistances coarse = distances_of(centred_box(), 24),
                      fine = distances_of(centred_box(), 48);
  EXPECT_GT(std::log2(coarse.error.largest / fine.error.largest), 0.8);
  EXPECT_LT(fine.error.largest, 0.25 * fine.nodes.spacing);
  EXPECT_GT(std::log2(coarse.error.root_mean_square / fine.error.root_mean_square), 1.2);
}

// Facets that are small relative to the cells look smooth: almost third order, until they are seen.
TEST(ColliderGrid, ErrorOfASmoothSurfaceFallsFaster) {
  const SurfaceMesh ball = testing::sphere_surface(1.0, 100, 200);
  const MadeDistances coarse = distances_of(ball, 8), fine = distances_of(ball, 16);
  EXPECT_GT(std::log2(coarse.error.largest / fine.error.largest), 2.2)
      << coarse.error.largest << " " << fine.error.largest;
  EXPECT_GT(std::log2(coarse.error.root_mean_square / fine.error.root_mean_square), 2.2)
      << coarse.error.root_mean_square << " " << fine.error.root_mean_square;
}

// A plate that lies in the middle of a layer of cells has no node inside; one of two cells has.
TEST(ColliderGrid, WallsThatAreTooThinAreMissedAndCounted) {
  SurfaceMesh plate = testing::box_surface({1.0, 1.0, 0.01});
  const auto missed = [](const SurfaceMesh& surface) {
    const SurfaceDistance distance(closed_surface(surface));
    // Nodes at z = -0.175, -0.125 ... 0.175: none of them in the plate around z = 0.
    const GridNodes nodes{{-0.2, -0.2, -0.175}, 0.05, {29, 29, 8}};
    const Result<DistanceGrid> grid =
        DistanceGrid::create(nodes, distances_at_nodes(distance, nodes, 1));
    EXPECT_TRUE(grid) << grid.error().message;
    return grid ? missed_share(distance, *grid, 2) : -1.0;
  };
  for (Vector3d& x : plate.vertices) x.z() -= 0.005;
  EXPECT_GT(missed(plate), 0.9);
  for (Vector3d& x : plate.vertices) x.z() *= 10.0;
  EXPECT_EQ(missed(plate), 0.0);
}

TEST(ColliderGrid, MarginIsKeptAndLimitsAreTold) {
  const BoundingBox box{{0, 0, 0}, {1, 0.5, 0.2}};
  for (const double margin : {0.0, 0.3}) {
    const Result<GridNodes> nodes = plan_nodes(box, 32, margin);
    ASSERT_TRUE(nodes);
    EXPECT_EQ(nodes->spacing, 1.0 / 32);
    const Vector3d high =
        nodes->at(nodes->counts[0] - 1, nodes->counts[1] - 1, nodes->counts[2] - 1);
    const double kept = std::max(margin, 3.0 / 32) - 1e-8;
    EXPECT_GE((box.low - nodes->origin).minCoeff(), kept);
    EXPECT_GE((high - box.high).minCoeff(), kept);
    EXPECT_LE((high - box.high).maxCoeff(), kept + 1.0 / 32);
  }
  const Result<GridNodes> large = plan_nodes({{0, 0, 0}, {1, 1, 1}}, 2000, 0.05);
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("up to 3"), std::string::npos) << large.error().message;
  EXPECT_FALSE(plan_nodes({{0, 0, 0}, {1, 1, 1}}, 64, 100.0));
}

}  // namespace
}  // namespace tremolo
