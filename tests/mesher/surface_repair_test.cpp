#include "precompute/mesher/surface/surface_repair.h"

#include <gtest/gtest.h>

#include "common/mesh/winding_number.h"
#include "precompute/mesher/surface/repair_steps.h"
#include "precompute/mesher/surface/surface_geometry.h"
#include "tests/support/meshes/surfaces.h"

namespace tremolo {
namespace {

using namespace testing;

SurfaceMesh moved(SurfaceMesh surface, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& x : surface.vertices) x += by;
  return surface;
}

// Rounding of sums over some thousand triangles.
constexpr double kRounding = 1e-12;

TEST(SurfaceRepair, LeavesASoundSurfaceAsItIs) {
  for (const SurfaceMesh& surface :
       {box_surface({0.3, 0.4, 0.5}), sphere_surface(0.4), torus_surface(0.3, 0.1)}) {
    const RepairedSurface repaired = repair_surface(surface);
    EXPECT_TRUE(repaired.findings.clean());
    EXPECT_TRUE(describe(repaired.findings).empty());
    EXPECT_EQ(repaired.mesh.triangles, surface.triangles);
  }
}

TEST(SurfaceRepair, ClosesASoup) {
  const SurfaceMesh whole = torus_surface(0.3, 0.1);
  const RepairedSurface repaired = repair_surface(soup(whole));
  EXPECT_TRUE(repaired.findings.clean());
  EXPECT_EQ(repaired.mesh.vertices.size(), whole.vertices.size());
  EXPECT_NEAR(enclosed_volume(repaired.mesh), enclosed_volume(whole), kRounding);
}

TEST(SurfaceRepair, ClosesGapsThatAreFarBelowTheEdges) {
  SurfaceMesh gaps = soup(sphere_surface(0.4));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-4e-6, 4e-6);
  for (Eigen::Vector3d& x : gaps.vertices)
    x += Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
  const RepairedSurface repaired = repair_surface(gaps);
  EXPECT_TRUE(repaired.findings.clean());
  EXPECT_NEAR(enclosed_volume(repaired.mesh), enclosed_volume(sphere_surface(0.4)), 1e-4);
}

TEST(SurfaceRepair, TurnsTrianglesOutwards) {
  const SurfaceMesh whole = sphere_surface(0.4);
  for (const SurfaceMesh& turned : {reversed(whole), turned_at_random(whole, 0.3)}) {
    const RepairedSurface repaired = repair_surface(turned);
    EXPECT_TRUE(repaired.findings.clean());
    EXPECT_GT(repaired.findings.turned, 0u);
    EXPECT_NEAR(enclosed_volume(repaired.mesh), enclosed_volume(whole), kRounding);
  }
}

TEST(SurfaceRepair, TurnsASurfaceWithAHoleByWhatSeesInfinity) {
  const SurfaceMesh open = sphere_surface(0.4, 24, 48, 0.4);
  const RepairedSurface repaired = repair_surface(reversed(open));
  EXPECT_EQ(repaired.findings.holes, 1u);
  EXPECT_EQ(repaired.findings.turned, open.triangles.size());
  EXPECT_GT(WindingNumber(repaired.mesh).at(Eigen::Vector3d::Zero()), 0.9);
}

TEST(SurfaceRepair, KeepsCavitiesAndLeavesInnerShellsOut) {
  const SurfaceMesh outer = sphere_surface(0.4), inner = sphere_surface(0.2);
  const double difference = enclosed_volume(outer) - enclosed_volume(inner);
  const SurfaceMesh cavity = together(outer, reversed(inner));
  // A file that is turned inside out as a whole says the same.
  for (const SurfaceMesh& surface : {cavity, reversed(cavity)}) {
    const RepairedSurface repaired = repair_surface(surface);
    EXPECT_EQ(repaired.findings.cavities, 1u);
    EXPECT_NEAR(enclosed_volume(repaired.mesh), difference, kRounding);
  }
  const RepairedSurface repaired = repair_surface(together(inner, outer));
  EXPECT_EQ(repaired.findings.inner_shells, 1u);
  EXPECT_EQ(repaired.findings.cavities, 0u);
  EXPECT_NEAR(enclosed_volume(repaired.mesh), enclosed_volume(outer), kRounding);
  // A body in a cavity is a body.
  const RepairedSurface nested = repair_surface(together(cavity, sphere_surface(0.1)));
  EXPECT_EQ(nested.findings.inner_shells, 0u);
  EXPECT_NEAR(enclosed_volume(nested.mesh), difference + enclosed_volume(sphere_surface(0.1)),
              kRounding);
}

TEST(SurfaceRepair, LeavesRepeatsOut) {
  const SurfaceMesh whole = box_surface({0.5, 0.5, 0.5});
  for (const SurfaceMesh& twice : {together(whole, whole), together(whole, reversed(whole))}) {
    const RepairedSurface repaired = repair_surface(twice);
    EXPECT_TRUE(repaired.findings.clean());
    EXPECT_EQ(repaired.findings.repeated, 12u);
    EXPECT_NEAR(enclosed_volume(repaired.mesh), 0.125, kRounding);
  }
}

TEST(SurfaceRepair, JoinsBodiesThatShareAWall) {
  const SurfaceMesh pair =
      together(box_surface({0.3, 0.3, 0.3}), box_surface({0.3, 0.3, 0.3}, {0.3, 0.0, 0.0}));
  const RepairedSurface repaired = repair_surface(pair);
  EXPECT_TRUE(repaired.findings.clean());
  EXPECT_EQ(repaired.findings.cancelled, 4u);
  EXPECT_NEAR(enclosed_volume(repaired.mesh), 2 * 0.027, kRounding);
}

// The wall's quad is cut along one diagonal by one body, and along the other by the other.
SurfaceMesh touching_boxes() {
  SurfaceMesh second = box_surface({0.3, 0.3, 0.3}, {0.3, 0.0, 0.0});
  second.triangles[8] = {0, 4, 2};
  second.triangles[9] = {6, 2, 4};
  SurfaceMesh first = box_surface({0.3, 0.3, 0.3});
  first.triangles[10] = {1, 3, 7};
  first.triangles[11] = {1, 7, 5};
  return together(first, second);
}

TEST(SurfaceRepair, JoinsBodiesThatShareAWallCutAlongTheOtherDiagonal) {
  const SurfaceMesh pair = touching_boxes();
  // As a file has them, with one vertex at each place, as triangles without common vertices, and
  // with both or one of the bodies inside out.
  SurfaceMesh one_inwards = pair;
  for (std::size_t t = 12; t < 24; ++t)
    std::swap(one_inwards.triangles[t][1], one_inwards.triangles[t][2]);
  SurfaceMesh shared = pair;
  const std::array<VertexId, 8> places = {1, 9, 3, 11, 5, 13, 7, 15};
  for (std::size_t t = 12; t < 24; ++t)
    for (VertexId& v : shared.triangles[t]) v = places[static_cast<std::size_t>(v) - 8];
  for (const SurfaceMesh& surface :
       {pair, shared, soup(pair), reversed(pair), reversed(soup(pair)), one_inwards}) {
    const RepairedSurface repaired = repair_surface(surface);
    EXPECT_TRUE(repaired.findings.clean());
    EXPECT_EQ(repaired.findings.united, 2u);
    EXPECT_NEAR(enclosed_volume(repaired.mesh), 2 * 0.027, kRounding);
  }
}

TEST(SurfaceRepair, UnitesBodiesWhoseTrianglesCoincideWhereTheyOverlap) {
  // Two bars of three cells each, the last cell of one being the first of the other: twelve of the
  // triangles are those of both.
  const auto bar = [](double low) {
    SurfaceMesh surface;
    for (int i = 0; i <= 3; ++i)
      for (const auto& [y, z] : {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}})
        surface.vertices.push_back({low + 0.1 * i, y, z});
    for (VertexId i = 0; i < 3; ++i)
      for (VertexId k = 0; k < 4; ++k) {
        const VertexId a = 4 * i + k, b = 4 * i + (k + 1) % 4;
        surface.triangles.push_back({a, b + 4, b});
        surface.triangles.push_back({a, a + 4, b + 4});
      }
    surface.triangles.insert(surface.triangles.end(),
                             {{0, 1, 2}, {0, 2, 3}, {12, 14, 13}, {12, 15, 14}});
    return reversed(surface);
  };
  ASSERT_NEAR(enclosed_volume(bar(0)), 0.003, kRounding);
  SurfaceMesh pair = together(bar(0), bar(0.2));
  const RepairedSurface repaired = repair_surface(pair);
  EXPECT_TRUE(repaired.findings.clean());
  EXPECT_EQ(repaired.findings.united, 2u);
  EXPECT_NEAR(enclosed_volume(repaired.mesh), 0.005, kRounding);
  // Objects tell them apart if no triangles have vertices in common.
  std::vector<std::uint32_t> object_of(pair.triangles.size(), 0);
  std::fill(object_of.begin() + object_of.size() / 2, object_of.end(), 1);
  const RepairedSurface objects = repair_surface(soup(pair), object_of);
  EXPECT_TRUE(objects.findings.clean());
  EXPECT_NEAR(enclosed_volume(objects.mesh), 0.005, kRounding);
}

TEST(SurfaceRepair, CountsEdgesAlongWhichBodiesTouch) {
  const SurfaceMesh box = box_surface({0.3, 0.3, 0.3});
  const SurfaceMesh hinge = together(box, moved(box, {0.3, 0.3, 0.0}));
  for (const SurfaceMesh& surface : {hinge, soup(hinge)}) {
    const RepairedSurface repaired = repair_surface(surface);
    EXPECT_EQ(repaired.findings.hinges, 1u);
    EXPECT_EQ(repaired.findings.branching_edges, 1u);
  }
  // A wall inside a box, and a fin on it, are none.
  SurfaceMesh divided = box;
  divided.triangles.push_back({0, 1, 7});
  divided.triangles.push_back({0, 7, 6});
  EXPECT_EQ(repair_surface(divided).findings.hinges, 0u);
  SurfaceMesh fin = box;
  fin.vertices.push_back({0, 0, 0.5});
  fin.triangles.push_back({4, 7, 8});
  EXPECT_EQ(repair_surface(fin).findings.hinges, 0u);
}

// With the turned triangles turned, the surface as given is oriented as the repaired one.
TEST(SurfaceRepair, SaysWhichOfTheGivenTrianglesItTurned) {
  const SurfaceMesh ball = sphere_surface(0.3);
  SurfaceMesh twice = reversed(ball);
  twice.triangles.insert(twice.triangles.begin(), twice.triangles[40]);
  for (const SurfaceMesh& given :
       {reversed(ball), soup(reversed(ball)), turned_at_random(ball, 0.3),
        turned_at_random(ball, 0.7), twice, together(ball, reversed(moved(ball, {0.7, 0, 0})))}) {
    const RepairedSurface repaired = repair_surface(given);
    ASSERT_EQ(repaired.turned.size(), given.triangles.size());
    SurfaceMesh turned = given;
    std::size_t count = 0;
    for (std::size_t t = 0; t < given.triangles.size(); ++t) {
      if (repaired.turned[t] == 0) continue;
      std::swap(turned.triangles[t][1], turned.triangles[t][2]);
      ++count;
    }
    EXPECT_EQ(repaired.findings.turned, count);
    for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
      const auto [a, b, c] = corners(turned, turned.triangles[t]);
      const Eigen::Vector3d centre(t > ball.triangles.size() ? 0.7 : 0.0, 0, 0);
      EXPECT_GT((b - a).cross(c - a).dot(a + b + c - 3 * centre), 0) << t;
    }
  }
}

TEST(SurfaceRepair, UnitesBodiesThatOverlap) {
  const SurfaceMesh a = box_surface({0.3, 0.3, 0.3});
  const SurfaceMesh b = box_surface({0.3, 0.3, 0.3}, {0.15, 0.1, 0.05});
  const double expected = 2 * 0.027 - 0.15 * 0.2 * 0.25;
  for (const SurfaceMesh& pair : {together(a, b), together(reversed(a), reversed(b))}) {
    const RepairedSurface repaired = repair_surface(pair);
    EXPECT_TRUE(repaired.findings.clean());
    EXPECT_EQ(repaired.findings.united, 2u);
    EXPECT_NEAR(enclosed_volume(repaired.mesh), expected, kRounding);
  }
}

// Corefinement's own order depends on the addresses of what it allocates.
TEST(SurfaceRepair, OrdersAUnionByPlace) {
  const SurfaceMesh pair =
      together(box_surface({0.3, 0.3, 0.3}), box_surface({0.3, 0.3, 0.3}, {0.15, 0.1, 0.05}));
  const SurfaceMesh united = repair_surface(pair).mesh;
  const auto before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  EXPECT_TRUE(std::is_sorted(united.vertices.begin(), united.vertices.end(), before));
  EXPECT_TRUE(std::is_sorted(united.triangles.begin(), united.triangles.end()));
}

TEST(SurfaceRepair, FindsHolesAndTheirSize) {
  // The cap over a hole of half angle a: pi sin^2 a, of a sphere's 2 pi (1 + cos a) left.
  const double a = 0.5;
  const RepairedSurface repaired = repair_surface(sphere_surface(0.4, 48, 96, a));
  EXPECT_EQ(repaired.findings.holes, 1u);
  EXPECT_NEAR(repaired.findings.hole_share, std::sin(a) * std::sin(a) / (2.0 * (1.0 + std::cos(a))),
              2e-3);
  EXPECT_FALSE(repaired.findings.clean());
  EXPECT_EQ(repair_surface(plane_surface(5)).findings.holes, 1u);
}

TEST(SurfaceRepair, TellsOneSidedSheetsFromTwoSidedOnes) {
  EXPECT_GT(repair_surface(strip_surface(1)).findings.one_sided_edges, 0u);
  EXPECT_EQ(repair_surface(strip_surface(2)).findings.one_sided_edges, 0u);
}

TEST(SurfaceRepair, CountsWhatItCannotMend) {
  // A fin on a box: three triangles at one edge.
  SurfaceMesh fin = box_surface({0.4, 0.4, 0.4});
  fin.vertices.push_back({0.2, 0.2, 0.8});
  fin.triangles.push_back({4, 7, 8});
  EXPECT_EQ(repair_surface(fin).findings.branching_edges, 1u);
  // A torus whose tube is wider than its ring runs through itself.
  EXPECT_GT(repair_surface(torus_surface(0.15, 0.2)).findings.crossings, 0u);
  SurfaceMesh flat = box_surface({0.4, 0.4, 0.4});
  flat.triangles.push_back({0, 1, 1});
  EXPECT_EQ(repair_surface(flat).findings.degenerate, 1u);
  EXPECT_TRUE(repair_surface(SurfaceMesh{}).mesh.triangles.empty());
}

TEST(SurfaceRepair, BodiesApartStayApart) {
  const RepairedSurface repaired =
      repair_surface(together(sphere_surface(0.2), moved(sphere_surface(0.2), {0.5, 0, 0})));
  EXPECT_TRUE(repaired.findings.clean());
  EXPECT_EQ(repaired.findings.shells, 2u);
}

}  // namespace
}  // namespace tremolo
