// Triangle surfaces: the boundary of a mesh, polygons as triangles, shares of faces.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// vertices: positions in metres. triangles: indices into vertices, counter-clockwise from outside.
struct SurfaceMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
};

// The boundary of a mesh in terms of the mesh's own vertices.
// vertex_ids: ascending ids of the vertices on the boundary. triangles: indices into vertex_ids.
struct BoundarySurface {
  std::vector<VertexId> vertex_ids;
  std::vector<Triangle> triangles;
};

// Faces that belong to exactly one tetrahedron, oriented outwards (the mesh must be positively
// oriented). Order: by tetrahedron, then by local face; the same mesh gives the same surface.
BoundarySurface boundary_surface(const TetMesh& mesh);

// The same with vertices of its own.
SurfaceMesh boundary_mesh(const TetMesh& mesh);

// From a vertex's id to its row. The index of `id` in `ids`, which ascend without repeats; nullopt
// if it is not among them.
inline std::optional<std::size_t> find_vertex(const std::vector<VertexId>& ids, VertexId id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  if (at == ids.end() || *at != id) return std::nullopt;
  return at - ids.begin();
}

// Distribution of a force on a face over its vertices. The fraction for each of `chosen` (ids; at
// least one); the sum is 1. A boundary triangle whose three corners are chosen gives a third of its
// area to each: a uniform traction over the face, whose resultant passes through the face's
// centroid for any mesh. Chosen vertices of no such triangle get nothing. Without any such triangle
// all fractions are equal. vertex_ids: of the boundary, ascending; triangles: indices into them;
// rest: their positions, m.
std::vector<double> area_shares(std::span<const VertexId> chosen,
                                std::span<const VertexId> vertex_ids,
                                std::span<const Triangle> triangles,
                                std::span<const Eigen::Vector3d> rest);

// Polygons in space -> triangles. Appends the n - 2 triangles of a polygon of n corners, each as
// three indices into `corners`; none for fewer than three corners. A convex polygon becomes a fan
// from its first corner. Other polygons are divided at ears in the plane of their mean normal, so
// that the triangles cover the region inside; one that crosses itself or has no area is divided as
// far as it has ears, and then as a fan.
void cut_polygon(std::span<const Eigen::Vector3d> corners,
                 std::vector<std::array<std::size_t, 3>>& triangles);

}  // namespace tremolo
