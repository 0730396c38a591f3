#include "precompute/collider/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "precompute/embedding/closest_point.h"

namespace tremolo {
namespace {

template <class Facet>
std::vector<BoundingBox> facet_boxes(const std::vector<Facet>& facets) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(facets.size());
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.corners;
    boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  return boxes;
}

}  // namespace

std::vector<SurfaceDistance::Facet> SurfaceDistance::facets_of(const ClosedSurface& closed) {
  const SurfaceMesh& surface = closed.surface;
  std::vector<Facet> facets;
  facets.reserve(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (closed.buried[t] != 0) continue;
    const Triangle& ids = surface.triangles[t];
    const Eigen::Vector3d &a = surface.vertices[ids[0]], &b = surface.vertices[ids[1]],
                          &c = surface.vertices[ids[2]];
    const Eigen::Vector3d normal = (b - a).cross(c - a).stableNormalized();
    facets.push_back({{a, b, c}, normal, normal.dot(a)});
  }
  return facets;
}

SurfaceDistance::SurfaceDistance(const ClosedSurface& closed)
    : facets_(facets_of(closed)), tree_(facet_boxes(facets_)), winding_(closed.surface) {}

// No triangle is nearer than its plane: most that the tree offers are left out by that.
double SurfaceDistance::magnitude(const Eigen::Vector3d& x) const {
  double best = std::numeric_limits<double>::infinity();
  const auto squared = [&](std::size_t t) {
    const Facet& facet = facets_[t];
    const double to_plane = facet.normal.dot(x) - facet.offset;
    if (to_plane * to_plane > 1.000001 * best) return best;
    const double found = closest_on_triangle(x, facet.corners).squared_distance;
    best = std::min(best, found);
    return found;
  };
  return std::sqrt(tree_.nearest(x, squared).squared_distance);
}

double SurfaceDistance::at(const Eigen::Vector3d& x) const {
  const double distance = magnitude(x);
  return is_inside(x) ? -distance : distance;
}

}  // namespace tremolo
