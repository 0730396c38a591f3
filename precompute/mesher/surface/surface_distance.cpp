#include "precompute/mesher/surface/surface_distance.h"

#include <algorithm>
#include <random>

namespace tremolo {

Eigen::Vector3d doubled_area(const SurfaceMesh& surface, const Triangle& triangle) {
  const auto at = [&](std::size_t i) -> const Eigen::Vector3d& {
    return surface.vertices[static_cast<std::size_t>(triangle[i])];
  };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

std::vector<SurfacePoint> spread_points(const SurfaceMesh& surface, std::size_t count) {
  std::vector<double> areas;
  for (const Triangle& t : surface.triangles) areas.push_back(doubled_area(surface, t).norm());
  std::vector<SurfacePoint> points;
  if (areas.empty()) return points;
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::mt19937_64 random(1);
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t t = pick(random);
    double u = uniform(random), v = uniform(random);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const auto corner = [&](std::size_t k) -> const Eigen::Vector3d& {
      return surface.vertices[static_cast<std::size_t>(surface.triangles[t][k])];
    };
    points.push_back({corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0)), t});
  }
  return points;
}

double distance_from(const SurfaceMesh& from, const TriangleTree& to, std::size_t samples) {
  double largest = 0;
  for (const Triangle& t : from.triangles)
    for (const VertexId v : t)
      largest = std::max(largest, to.nearest(from.vertices[static_cast<std::size_t>(v)]).distance);
  for (const SurfacePoint& x : spread_points(from, samples))
    largest = std::max(largest, to.nearest(x.point).distance);
  return largest;
}

}  // namespace tremolo
