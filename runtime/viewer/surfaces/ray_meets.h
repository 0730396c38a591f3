// Intersection of a ray with a triangle.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "runtime/viewer/camera/camera.h"

namespace tremolo {

// Distance along the ray's direction to the triangle, by Möller and Trumbore (1997); nothing if it
// misses. A ray along a common edge meets both triangles, whatever is rounded.
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

}  // namespace tremolo
