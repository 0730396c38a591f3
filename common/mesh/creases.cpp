#include "common/mesh/creases.h"

#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "common/union_find.h"

namespace tremolo {

using Eigen::Vector3d;

CreasedSurface split_at_creases(std::span<const Vector3d> vertices,
                                std::span<const Triangle> triangles) {
  const auto at = [&](VertexId v) { return vertices[static_cast<std::size_t>(v)]; };
  std::vector<Vector3d> normals;
  std::vector<std::vector<std::size_t>> corners(vertices.size());  // 3 t + k, of each vertex
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    normals.push_back((at(b) - at(a)).cross(at(c) - at(a)).normalized());
    for (std::size_t k = 0; k < 3; ++k)
      corners[static_cast<std::size_t>(triangles[t][k])].push_back(3 * t + k);
  }
  std::vector<std::size_t> side(3 * triangles.size());
  std::iota(side.begin(), side.end(), std::size_t{0});
  const double least = std::cos(kCrease);
  for (const std::vector<std::size_t>& around : corners)
    for (std::size_t i = 0; i < around.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (normals[around[i] / 3].dot(normals[around[j] / 3]) >= least)
          join_sets(side, around[i], around[j]);

  CreasedSurface made;
  made.triangles.assign(triangles.begin(), triangles.end());
  made.vertex_of.resize(vertices.size());
  std::iota(made.vertex_of.begin(), made.vertex_of.end(), VertexId{0});
  for (std::size_t v = 0; v < corners.size(); ++v) {
    std::map<std::size_t, VertexId> vertex_of_side;
    for (const std::size_t corner : corners[v]) {
      const auto [found, is_new] = vertex_of_side.try_emplace(root_of(side, corner), VertexId{0});
      if (is_new) {
        const bool first = vertex_of_side.size() == 1;
        found->second = static_cast<VertexId>(first ? v : made.vertex_of.size());
        if (!first) made.vertex_of.push_back(static_cast<VertexId>(v));
      }
      made.triangles[corner / 3][corner % 3] = found->second;
    }
  }
  return made;
}

}  // namespace tremolo
