#include "runtime/apps/view/shape/creased_shape.h"

#include <Eigen/Geometry>

#include "common/mesh/creases.h"

namespace tremolo {

using Eigen::Vector3d;

TriangleShape creased_shape(const std::vector<Vector3d>& rest,
                            std::span<const Triangle> triangles) {
  const CreasedSurface creased = split_at_creases(rest, triangles);
  const auto at = [&](VertexId v) {
    return rest[static_cast<std::size_t>(creased.vertex_of[static_cast<std::size_t>(v)])];
  };
  std::vector<Vector3d> normals(creased.vertex_of.size(), Vector3d::Zero());
  for (const auto& [a, b, c] : creased.triangles) {
    const Vector3d area = (at(b) - at(a)).cross(at(c) - at(a));
    for (const VertexId v : {a, b, c}) normals[static_cast<std::size_t>(v)] += area;
  }
  TriangleShape shape;
  for (std::size_t v = 0; v < normals.size(); ++v)
    shape.add(at(static_cast<VertexId>(v)), normals[v].normalized());
  for (const auto& [a, b, c] : creased.triangles)
    shape.add_triangle(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                       static_cast<std::uint32_t>(c));
  return shape;
}

}  // namespace tremolo
