#include "precompute/embedding/surface_contacts.h"

#include "precompute/embedding/closest_point.h"

namespace tremolo {
namespace {

BoxTree tree_of(const RenderSurface& surface) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const std::array<Eigen::Vector3d, 3> x = corners_of(surface, t);
    boxes.push_back({x[0].cwiseMin(x[1]).cwiseMin(x[2]), x[0].cwiseMax(x[1]).cwiseMax(x[2])});
  }
  return BoxTree(boxes);
}

}  // namespace

std::array<Eigen::Vector3d, 3> corners_of(const RenderSurface& surface, std::size_t triangle) {
  const Triangle& t = surface.triangles[triangle];
  return {surface.vertices[t[0]], surface.vertices[t[1]], surface.vertices[t[2]]};
}

SurfaceContacts::SurfaceContacts(const RenderSurface& surface)
    : surface_(surface), tree_(tree_of(surface)) {}

SurfaceContact SurfaceContacts::at(const Eigen::Vector3d& x) const {
  const auto distance = [&](std::size_t t) {
    return closest_on_triangle(x, corners_of(surface_, t)).squared_distance;
  };
  const std::size_t triangle = tree_.nearest(x, distance).item;
  return {triangle, closest_on_triangle(x, corners_of(surface_, triangle)).weights};
}

}  // namespace tremolo
