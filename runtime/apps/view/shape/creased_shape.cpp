#include "runtime/apps/view/shape/creased_shape.h"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

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

CreasedSheet::CreasedSheet(const std::vector<Vector3d>& rest, std::span<const Triangle> triangles,
                           std::span<const std::uint32_t> group_of)
    : made_(split_at_creases(rest, triangles, group_of)), normal_of_(made_.sides()) {
  const auto is_sharp = [this](VertexId v) {
    return made_.sharp[made_.side_of[static_cast<std::size_t>(v)]] != 0;
  };
  for (const Triangle& t : made_.triangles)
    if (std::any_of(t.begin(), t.end(), is_sharp)) at_edges_.push_back(t);
}

CreasedSheet CreasedSheet::as_given(std::size_t vertices, std::span<const Triangle> triangles) {
  CreasedSheet sheet;
  sheet.made_.triangles.assign(triangles.begin(), triangles.end());
  sheet.made_.vertex_of.resize(vertices);
  std::iota(sheet.made_.vertex_of.begin(), sheet.made_.vertex_of.end(), VertexId{0});
  return sheet;
}

std::vector<float> CreasedSheet::spread(std::span<const float> values, std::size_t numbers) const {
  std::vector<float> own(numbers * vertices());
  for (std::size_t v = 0; v < vertices(); ++v)
    std::copy_n(values.data() + numbers * static_cast<std::size_t>(made_.vertex_of[v]), numbers,
                own.data() + numbers * v);
  return own;
}

void CreasedSheet::pose(std::span<const float> positions, std::span<const float> normals) {
  using Eigen::Vector3f;
  positions_ = spread(positions, 3);
  normals_ = spread(normals, 3);
  if (at_edges_.empty()) return;
  std::fill(normal_of_.begin(), normal_of_.end(), Vector3f::Zero());
  const auto at = [this](VertexId v) {
    return Eigen::Map<const Vector3f>(positions_.data() + 3 * static_cast<std::size_t>(v));
  };
  for (const Triangle& t : at_edges_) {
    const Vector3f normal = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    for (const VertexId v : t) normal_of_[made_.side_of[static_cast<std::size_t>(v)]] += normal;
  }
  for (std::size_t v = 0; v < vertices(); ++v)
    if (made_.sharp[made_.side_of[v]] != 0)
      Eigen::Map<Vector3f>(normals_.data() + 3 * v) = normal_of_[made_.side_of[v]].normalized();
}

}  // namespace tremolo
