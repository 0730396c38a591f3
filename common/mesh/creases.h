// Sharp edges of a surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The surface with a vertex for each side of a sharp edge.
struct CreasedSurface {
  std::vector<VertexId> vertex_of;  // of each vertex: the given one that is there
  std::vector<Triangle> triangles;  // the given ones, in their order
  // Of each vertex: vertices with the same number are on the same side and share a normal.
  std::vector<std::uint32_t> side_of;
  std::vector<std::uint8_t> sharp;  // of each side: 1 if there is another one at its point

  std::size_t sides() const { return sharp.size(); }
};

// Triangles that meet in a vertex at less than kCrease share it, and so do those between which
// there is a chain of such: edges of boxes and rims of cylinders are sharp, and round sides smooth.
// The first vertices are the given ones, in their order. vertices: m.
inline constexpr double kCrease = 0.7;  // rad, between the normals
// group_of: of each vertex, equal for vertices that are one point of the surface, as along a seam
// of texture coordinates; empty: each is a point of its own.
CreasedSurface split_at_creases(std::span<const Eigen::Vector3d> vertices,
                                std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> group_of = {});

}  // namespace tremolo
