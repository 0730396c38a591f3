// Winding number, nearest points, rays, wall thickness and sizes.
#include <gtest/gtest.h>

#include "common/mesh/winding_number.h"
#include "precompute/mesher/cgal/size_field.h"
#include "precompute/mesher/surface/surface_geometry.h"
#include "tests/support/meshes/surfaces.h"

namespace tremolo {
namespace {

using namespace testing;

Eigen::Vector3d random_point(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> uniform(-reach, reach);
  return {uniform(random), uniform(random), uniform(random)};
}

TEST(WindingNumber, IsOneInsideAndZeroOutside) {
  const WindingNumber winding(sphere_surface(1.0));
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d x = random_point(random, 1.5);
    if (std::abs(x.norm() - 1.0) < 0.01) continue;
    // Error of the dipoles, measured: 0.004 on average, 0.04 at worst; one half decides.
    EXPECT_NEAR(winding.at(x), x.norm() < 1.0 ? 1.0 : 0.0, 0.05) << x.transpose();
  }
}

TEST(WindingNumber, AddsUpOverThePartsOfASurface) {
  const SurfaceMesh torus = torus_surface(1.0, 0.3);
  const WindingNumber whole(torus);
  SurfaceMesh half = torus, rest = torus;
  half.triangles.resize(torus.triangles.size() / 2);
  rest.triangles.erase(rest.triangles.begin(),
                       rest.triangles.begin() + static_cast<std::ptrdiff_t>(half.triangles.size()));
  const WindingNumber a(half), b(rest), turned(reversed(half));
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d x = random_point(random, 1.5);
    EXPECT_NEAR(a.at(x) + b.at(x), whole.at(x), 0.05);
    EXPECT_NEAR(turned.at(x), -a.at(x), 1e-9);  // the order of the leaves may differ
  }
}

TEST(WindingNumber, IsHalfInTheOpeningOfAHalfSphere) {
  const WindingNumber winding(sphere_surface(1.0, 64, 128, 0.5 * std::numbers::pi));
  // Seen from the centre, what the dipoles leave out has one sign.
  EXPECT_NEAR(winding.at(Eigen::Vector3d::Zero()), 0.5, 0.03);
}

TEST(TriangleTree, FindsTheNearestPointAndTheFirstHit) {
  const SurfaceMesh box = box_surface({2.0, 2.0, 2.0}, {-1.0, -1.0, -1.0});
  const TriangleTree tree(box);
  std::mt19937_64 random(3);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d x = random_point(random, 3.0);
    const Eigen::Vector3d clamped = x.cwiseMax(-1.0).cwiseMin(1.0);
    const double expected = clamped == x ? (1.0 - x.cwiseAbs().maxCoeff()) : (x - clamped).norm();
    const NearestPoint near = tree.nearest(x);
    EXPECT_NEAR(near.distance, expected, 1e-12);
    EXPECT_NEAR(near.point.cwiseAbs().maxCoeff(), 1.0, 1e-12);
  }
  EXPECT_NEAR(tree.first_hit({0.1, 0.2, 0.3}, {1, 0, 0}, 99).distance, 0.9, 1e-12);
  EXPECT_NEAR(tree.first_hit({-4.0, 0.2, 0.3}, {1, 0, 0}, 99).distance, 3.0, 1e-12);
  EXPECT_TRUE(std::isinf(tree.first_hit({0.1, 0.2, 3.0}, {0, 0, 1}, 99).distance));
}

TEST(WallSamples, FindTheThicknessOfAPlate) {
  const SurfaceMesh plate = box_surface({1.0, 1.0, 0.05});
  const TriangleTree tree(plate);
  std::size_t exact = 0;
  const std::vector<WallSample> walls = wall_samples(plate, tree, {}, 2000);
  for (const WallSample& wall : walls) exact += std::abs(wall.thickness - 0.05) < 1e-9;
  // Nine tenths of the area are the two faces, which see each other except near the rim.
  EXPECT_GT(static_cast<double>(exact), 0.8 * static_cast<double>(walls.size()));
}

TEST(WallSamples, LookThroughTrianglesWithinTheSolid) {
  // Two boxes that overlap: behind a face of the one the solid continues.
  const SurfaceMesh pair =
      together(box_surface({1.0, 1.0, 1.0}), box_surface({1.0, 1.0, 1.0}, {0.5, 0.0, 0.0}));
  const TriangleTree tree(pair);
  const WindingNumber winding(pair);
  const Inside inside = [&](const Eigen::Vector3d& x) { return winding.at(x) > 0.5; };
  double along = 0;
  for (const WallSample& wall : wall_samples(pair, tree, inside, 2000)) {
    EXPECT_FALSE(std::abs(wall.point[0] - 0.5) < 1e-9 && wall.point[1] > 1e-6 &&
                 wall.point[1] < 1 - 1e-6 && wall.point[2] > 1e-6 && wall.point[2] < 1 - 1e-6)
        << "a face within the solid was sampled";
    if (wall.point[0] < 1e-9) along = std::max(along, wall.thickness);
  }
  EXPECT_NEAR(along, 1.5, 1e-4);
}

TEST(SizeField, IsBoundedSteadyAndFineAtThinWalls) {
  const SurfaceMesh plate = box_surface({1.0, 1.0, 0.05});
  const std::vector<WallSample> walls = wall_samples(plate, TriangleTree(plate), {}, 4000);
  const SizeField sizes(bounding_box(plate.vertices), walls, 0.2, 0.01);
  std::mt19937_64 random(4);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d x = random_point(random, 1.2), d = 0.01 * random_point(random, 1.0);
    EXPECT_GE(sizes.at(x), 0.01 - 1e-6);
    EXPECT_LE(sizes.at(x), 0.2 + 1e-6);
    // Growth by a half along each of three axes, and float.
    EXPECT_LE(std::abs(sizes.at(x + d) - sizes.at(x)), 0.5 * d.lpNorm<1>() + 1e-6);
  }
  EXPECT_LT(sizes.at({0.5, 0.5, 0.025}), 0.07);
}

TEST(SurfaceDistance, OfConcentricSpheresIsTheDifferenceOfTheRadii) {
  const SurfaceMesh small = sphere_surface(1.0, 64, 128), large = sphere_surface(1.1, 64, 128);
  // The polyhedra are within 1e-3 of the spheres.
  EXPECT_NEAR(distance_from(small, TriangleTree(large), 3000), 0.1, 1.5e-3);
  EXPECT_NEAR(distance_from(large, TriangleTree(small), 3000), 0.1, 1.5e-3);
}

}  // namespace
}  // namespace tremolo
