#include "precompute/collider/surface_distance.h"

#include <cmath>
#include <vector>

#include "precompute/embedding/closest_point.h"

namespace tremolo {
namespace {

SurfaceMesh without_buried(const ClosedSurface& closed) {
  SurfaceMesh bare{closed.surface.vertices, {}};
  for (std::size_t t = 0; t < closed.surface.triangles.size(); ++t)
    if (closed.buried[t] == 0) bare.triangles.push_back(closed.surface.triangles[t]);
  return bare;
}

std::vector<BoundingBox> triangle_boxes(const SurfaceMesh& surface) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]],
                          &c = surface.vertices[t[2]];
    boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  return boxes;
}

}  // namespace

SurfaceDistance::SurfaceDistance(const ClosedSurface& closed)
    : surface_(without_buried(closed)), tree_(triangle_boxes(surface_)), winding_(closed.surface) {}

std::array<Eigen::Vector3d, 3> SurfaceDistance::corners(std::size_t triangle) const {
  const Triangle& t = surface_.triangles[triangle];
  return {surface_.vertices[t[0]], surface_.vertices[t[1]], surface_.vertices[t[2]]};
}

double SurfaceDistance::magnitude(const Eigen::Vector3d& x) const {
  return std::sqrt(
      tree_
          .nearest(
              x, [&](std::size_t t) { return closest_on_triangle(x, corners(t)).squared_distance; })
          .squared_distance);
}

double SurfaceDistance::at(const Eigen::Vector3d& x) const {
  const double distance = magnitude(x);
  return is_inside(x) ? -distance : distance;
}

}  // namespace tremolo
