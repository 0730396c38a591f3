#include "precompute/mesher/surface/surface_geometry.h"

#include <algorithm>

namespace tremolo {

using Point = Eigen::Vector3d;

Point doubled_area(const SurfaceMesh& surface, const Triangle& triangle) {
  const auto [a, b, c] = corners(surface, triangle);
  return (b - a).cross(c - a);
}

double area(const SurfaceMesh& surface) {
  double sum = 0;
  for (const Triangle& t : surface.triangles) sum += 0.5 * doubled_area(surface, t).norm();
  return sum;
}

double volume_below(const SurfaceMesh& surface, const Triangle& triangle) {
  const auto [a, b, c] = corners(surface, triangle);
  return a.dot(b.cross(c)) / 6.0;
}

Point random_point(const SurfaceMesh& surface, const Triangle& triangle, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double u = uniform(random), v = uniform(random);
  if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
  const auto [a, b, c] = corners(surface, triangle);
  return a + u * (b - a) + v * (c - a);
}

std::vector<SurfacePoint> spread_points(const SurfaceMesh& surface, std::size_t count) {
  std::vector<double> areas;
  for (const Triangle& t : surface.triangles) areas.push_back(doubled_area(surface, t).norm());
  std::vector<SurfacePoint> points;
  if (areas.empty()) return points;
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::mt19937_64 random(1);
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t t = pick(random);
    const Triangle& triangle = surface.triangles[t];
    points.push_back(
        {random_point(surface, triangle, random), doubled_area(surface, triangle).normalized(), t});
  }
  return points;
}

double distance_from(const SurfaceMesh& from, const TriangleTree& to, std::size_t samples) {
  double largest = 0;
  for (const Triangle& t : from.triangles)
    for (const Point& x : corners(from, t)) largest = std::max(largest, to.nearest(x).distance);
  for (const SurfacePoint& x : spread_points(from, samples))
    largest = std::max(largest, to.nearest(x.point).distance);
  return largest;
}

}  // namespace tremolo
