#include "precompute/mesher/surface/surface_repair.h"

#include <gtest/gtest.h>

#include "common/mesh/winding_number.h"
#include "precompute/mesher/surface/repair_steps.h"
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
