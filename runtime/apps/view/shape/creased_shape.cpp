#include "runtime/apps/view/shape/creased_shape.h"

#include <cmath>

#include <Eigen/Geometry>

namespace tremolo {

using Eigen::Vector3d;

TriangleShape creased_shape(const std::vector<Vector3d>& rest,
                            std::span<const Triangle> triangles) {
  std::vector<Vector3d> areas;  // along the normals
  std::vector<std::vector<std::size_t>> around(rest.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    const Vector3d& origin = rest[static_cast<std::size_t>(a)];
    areas.push_back((rest[static_cast<std::size_t>(b)] - origin)
                        .cross(rest[static_cast<std::size_t>(c)] - origin));
    for (const VertexId v : triangles[t]) around[static_cast<std::size_t>(v)].push_back(t);
  }
  const double least = std::cos(kCrease);
  TriangleShape shape;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const VertexId v : triangles[t]) {
      Vector3d normal = Vector3d::Zero();
      for (const std::size_t other : around[static_cast<std::size_t>(v)])
        if (areas[t].dot(areas[other]) >= least * areas[t].norm() * areas[other].norm())
          normal += areas[other];
      shape.triangles.push_back(shape.add(rest[static_cast<std::size_t>(v)], normal.normalized()));
    }
  return shape;
}

}  // namespace tremolo
