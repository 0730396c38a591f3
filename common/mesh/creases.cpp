#include "common/mesh/creases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "common/union_find.h"

namespace tremolo {

using Eigen::Vector3d;

namespace {

// Joins the corners 3 t + k at each point between which there is no sharp edge. normals: of the
// triangles.
std::vector<std::size_t> sides_of_corners(const std::vector<std::vector<std::size_t>>& points,
                                          const std::vector<Vector3d>& normals) {
  std::vector<std::size_t> side(3 * normals.size());
  std::iota(side.begin(), side.end(), std::size_t{0});
  const double least = std::cos(kCrease);
  for (const std::vector<std::size_t>& around : points)
    for (std::size_t i = 0; i < around.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (normals[around[i] / 3].dot(normals[around[j] / 3]) >= least)
          join_sets(side, around[i], around[j]);
  return side;
}

}  // namespace

CreasedSurface split_at_creases(std::span<const Vector3d> vertices,
                                std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> group_of) {
  const auto at = [&](VertexId v) { return vertices[static_cast<std::size_t>(v)]; };
  std::size_t points = vertices.size();
  for (const std::uint32_t group : group_of) points = std::max(points, std::size_t{group} + 1);
  const auto point_of = [&](std::size_t v) { return group_of.empty() ? v : group_of[v]; };
  std::vector<Vector3d> normals;
  // The corners 3 t + k of each vertex, and of each point.
  std::vector<std::vector<std::size_t>> corners(vertices.size()), around(points);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    normals.push_back((at(b) - at(a)).cross(at(c) - at(a)).normalized());
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(triangles[t][k]);
      corners[v].push_back(3 * t + k);
      around[point_of(v)].push_back(3 * t + k);
    }
  }
  std::vector<std::size_t> side = sides_of_corners(around, normals);

  CreasedSurface made;
  std::map<std::size_t, std::uint32_t> numbers;  // of sides, by their root
  for (const std::vector<std::size_t>& corners_there : around) {
    const std::size_t before = numbers.size();
    for (const std::size_t corner : corners_there)
      numbers.try_emplace(root_of(side, corner), static_cast<std::uint32_t>(numbers.size()));
    made.sharp.resize(numbers.size(), numbers.size() > before + 1 ? 1 : 0);
  }
  made.triangles.assign(triangles.begin(), triangles.end());
  made.vertex_of.resize(vertices.size());
  std::iota(made.vertex_of.begin(), made.vertex_of.end(), VertexId{0});
  made.side_of.resize(vertices.size());
  for (std::size_t v = 0; v < corners.size(); ++v) {
    if (corners[v].empty()) {
      made.side_of[v] = static_cast<std::uint32_t>(made.sharp.size());
      made.sharp.push_back(0);
    }
    std::map<std::uint32_t, VertexId> vertex_of_side;
    for (const std::size_t corner : corners[v]) {
      const std::uint32_t number = numbers.at(root_of(side, corner));
      const auto [found, is_new] = vertex_of_side.try_emplace(number, VertexId{0});
      if (is_new) {
        const bool first = vertex_of_side.size() == 1;
        found->second = static_cast<VertexId>(first ? v : made.vertex_of.size());
        if (!first) {
          made.vertex_of.push_back(static_cast<VertexId>(v));
          made.side_of.emplace_back();
        }
        made.side_of[static_cast<std::size_t>(found->second)] = number;
      }
      made.triangles[corner / 3][corner % 3] = found->second;
    }
  }
  return made;
}

}  // namespace tremolo
