#include "common/mesh/refined_surface.h"

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d twice_area(const SurfaceMesh& mesh, const Triangle& triangle) {
  const Vector3d& at = mesh.vertices[triangle[0]];
  return (mesh.vertices[triangle[1]] - at).cross(mesh.vertices[triangle[2]] - at);
}

// A square of two triangles and a small one next to it.
SurfaceMesh square() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1.1, 0.5, 0}},
          {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}};
}

TEST(RefinedSurface, KeepsAreasAndVerticesAndHasShortEdges) {
  const SurfaceMesh surface = square();
  const RefinedSurface refined = refine_surface(surface, 0.1, 10'000);
  Vector3d sum = Vector3d::Zero();
  for (const Triangle& triangle : refined.mesh.triangles) {
    const Vector3d twice = twice_area(refined.mesh, triangle);
    EXPECT_GT(twice.z(), 0.0);
    sum += twice;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LE((refined.mesh.vertices[triangle[k]] - refined.mesh.vertices[triangle[(k + 1) % 3]])
                    .norm(),
                0.1);
  }
  EXPECT_NEAR(sum.z(), 2.0 + 0.1, 1e-12);
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    EXPECT_EQ(refined.mesh.vertices[i], surface.vertices[i]);
    EXPECT_EQ(refined.origin[i], i);
  }
}

TEST(RefinedSurface, LeavesSmallTrianglesAndNeedlesDoNotMultiply) {
  const SurfaceMesh surface = square();
  const RefinedSurface same = refine_surface(surface, 1.0, 100);
  EXPECT_EQ(same.mesh.triangles, surface.triangles);
  const SurfaceMesh needles = {{{0, 0, 0}, {1, 0, 0}, {0, 1e-6, 0}, {1, 1e-6, 0}},
                               {{0, 1, 2}, {1, 3, 2}}};
  EXPECT_LT(refine_surface(needles, 1e-7, 100).mesh.vertices.size(), 500U);
}

}  // namespace
}  // namespace tremolo
