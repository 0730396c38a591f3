#include "precompute/mesher/surface/surface_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

namespace tremolo {
namespace {

using PlainKernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<PlainKernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<PlainKernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<PlainKernel, Primitive>>;

PlainKernel::Point_3 plain_point(const Eigen::Vector3d& x) {
  return {x[0], x[1], x[2]};
}

}  // namespace

struct TriangleTree::Contents {
  Triangles triangles;
  Tree tree;
  std::size_t index(Triangles::const_iterator at) const {
    return static_cast<std::size_t>(at - triangles.begin());
  }
};

TriangleTree::TriangleTree(const SurfaceMesh& surface) : contents_(std::make_unique<Contents>()) {
  const auto& x = surface.vertices;
  for (const Triangle& t : surface.triangles)
    contents_->triangles.emplace_back(plain_point(x[t[0]]), plain_point(x[t[1]]),
                                      plain_point(x[t[2]]));
  contents_->tree.rebuild(contents_->triangles.begin(), contents_->triangles.end());
  if (!contents_->triangles.empty()) {
    contents_->tree.build();
    contents_->tree.accelerate_distance_queries();
  }
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;
TriangleTree& TriangleTree::operator=(TriangleTree&&) noexcept = default;

NearestPoint TriangleTree::nearest(const Eigen::Vector3d& x) const {
  const auto [point, at] = contents_->tree.closest_point_and_primitive(plain_point(x));
  NearestPoint result;
  result.point = {point.x(), point.y(), point.z()};
  result.triangle = contents_->index(at);
  result.distance = (result.point - x).norm();
  return result;
}

Hit TriangleTree::first_hit(const Eigen::Vector3d& x, const Eigen::Vector3d& direction,
                            std::size_t skipped) const {
  const PlainKernel::Point_3 from = plain_point(x);
  const PlainKernel::Ray_3 ray(from,
                               PlainKernel::Vector_3(direction[0], direction[1], direction[2]));
  const auto skip = [&](const Primitive::Id& id) { return contents_->index(id) == skipped; };
  const auto met = contents_->tree.first_intersection(ray, skip);
  Hit hit{std::numeric_limits<double>::infinity(), 0};
  if (!met) return hit;
  hit.triangle = contents_->index(met->second);
  if (const auto* point = boost::get<PlainKernel::Point_3>(&met->first))
    hit.distance = std::sqrt(CGAL::squared_distance(*point, from));
  else if (const auto* segment = boost::get<PlainKernel::Segment_3>(&met->first))
    hit.distance = std::sqrt(std::min(CGAL::squared_distance(segment->source(), from),
                                      CGAL::squared_distance(segment->target(), from)));
  return hit;
}

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
