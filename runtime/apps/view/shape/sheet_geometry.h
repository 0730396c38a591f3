// The geometry of surfaces of triangles: where a ray meets one, its normals.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/mesh/tet_mesh.h"
#include "runtime/apps/view/camera/camera.h"

namespace tremolo {

// Intersection of a ray with a triangle. Distance along the ray's direction to the triangle, by
// Möller and Trumbore (1997); nothing if it misses. A ray along a common edge meets both triangles,
// whatever is rounded.
inline std::optional<double> meets(const CameraRay& ray, const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  using Eigen::Vector3d;
  const Vector3d ab = b - a, ac = c - a, normal = ray.direction.cross(ac);
  const double size = ab.dot(normal);
  if (size == 0.0) return std::nullopt;
  const Vector3d from = ray.origin - a, turned = from.cross(ab);
  const double u = from.dot(normal) / size, v = ray.direction.dot(turned) / size;
  const double far = ac.dot(turned) / size;
  constexpr double kEdge = 1e-9;  // of the triangle
  if (!(u >= -kEdge && v >= -kEdge && u + v <= 1.0 + kEdge && far > 0.0)) return std::nullopt;
  return far;
}

// The nearest point at which a ray meets a surface.
struct RayHit {
  double distance = std::numeric_limits<double>::infinity();
  std::size_t corner = 0;  // the vertex of the triangle that is nearest to the point
};

// Replaces `hit` by that of a nearer triangle; false if there is none. place(v): position of vertex
// v, m.
template <class Place>
bool find_nearer(const CameraRay& ray, std::span<const Triangle> triangles, const Place& place,
                 RayHit& hit) {
  const double before = hit.distance;
  for (const Triangle& t : triangles) {
    const auto far = meets(ray, place(t[0]), place(t[1]), place(t[2]));
    if (!far || *far >= hit.distance) continue;
    hit.distance = *far;
    const Eigen::Vector3d point = ray.origin + *far * ray.direction;
    const auto off = [&](VertexId v) { return (place(v) - point).squaredNorm(); };
    hit.corner = static_cast<std::size_t>(*std::min_element(
        t.begin(), t.end(), [&off](VertexId a, VertexId b) { return off(a) < off(b); }));
  }
  return hit.distance < before;
}

// Overwrites normals by those of the vertices: the mean of the triangles' normals, weighted by
// their areas; zero where these cancel. positions: x y z of each vertex.
inline void mean_normals(std::span<const Triangle> triangles, const std::vector<float>& positions,
                         std::vector<float>& normals) {
  using Eigen::Vector3f;
  normals.assign(positions.size(), 0.0F);
  const auto at = [&positions](VertexId v) {
    return Eigen::Map<const Vector3f>(positions.data() + 3 * static_cast<std::size_t>(v));
  };
  for (const Triangle& t : triangles) {
    const Vector3f normal = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    for (const VertexId v : t)
      Eigen::Map<Vector3f>(normals.data() + 3 * static_cast<std::size_t>(v)) += normal;
  }
  for (std::size_t k = 0; k < normals.size(); k += 3)
    Eigen::Map<Vector3f>(normals.data() + k).normalize();
}

// Mean length of the triangles' edges; 0: there are none.
inline double mean_edge(std::span<const Triangle> triangles, const std::vector<float>& positions) {
  const auto at = [&positions](VertexId v) {
    return Eigen::Map<const Eigen::Vector3f>(positions.data() + 3 * static_cast<std::size_t>(v));
  };
  double sum = 0.0;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum += static_cast<double>((at(t[(k + 1) % 3]) - at(t[k])).norm());
  return triangles.empty() ? 0.0 : sum / (3.0 * static_cast<double>(triangles.size()));
}

}  // namespace tremolo
