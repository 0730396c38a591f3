// Sharp edges of a surface.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The surface with a vertex for each side of a sharp edge.
struct CreasedSurface {
  std::vector<VertexId> vertex_of;  // of each vertex: the given one that is there
  std::vector<Triangle> triangles;  // the given ones, in their order
};

// Triangles that meet in a vertex at less than kCrease share it, and so do those between which
// there is a chain of such: edges of boxes and rims of cylinders are sharp, and round sides smooth.
// The first vertices are the given ones, in their order. vertices: m.
inline constexpr double kCrease = 0.7;  // rad, between the normals
CreasedSurface split_at_creases(std::span<const Eigen::Vector3d> vertices,
                                std::span<const Triangle> triangles);

}  // namespace tremolo
