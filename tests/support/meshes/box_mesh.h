// A box of cells, each cut into six tetrahedra along its main diagonal.
#pragma once

#include <algorithm>
#include <array>

#include "common/mesh/edge_points.h"

namespace tremolo::testing {

// cells: along x, y, z. size: of the box, m; one corner at the origin. Vertex (i, j, k) is
// i + (nx+1) * (j + (ny+1) * k).
inline TetMesh box_mesh(const std::array<int, 3>& cells, const Eigen::Vector3d& size) {
  TetMesh mesh;
  const int nx = cells[0] + 1, ny = cells[1] + 1;
  for (int k = 0; k <= cells[2]; ++k)
    for (int j = 0; j <= cells[1]; ++j)
      for (int i = 0; i <= cells[0]; ++i)
        mesh.vertices.push_back(Eigen::Vector3d(size.x() * i / cells[0], size.y() * j / cells[1],
                                                size.z() * k / cells[2]));
  const int stride[3] = {1, nx, nx * ny};
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i) {
        const int corner = i + nx * (j + ny * k);
        std::array<int, 3> axes = {0, 1, 2};
        do {
          const int a = corner + stride[axes[0]];
          const int b = a + stride[axes[1]];
          const int c = b + stride[axes[2]];
          Tetrahedron tet = {corner, a, b, c};
          if (signed_volume(mesh, tet) < 0) std::swap(tet[2], tet[3]);
          mesh.tetrahedra.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return mesh;
}

// The mesh with edge points for order 2.
inline TetMesh of_order(TetMesh mesh, int order) {
  if (order == 2 && !add_edge_points(mesh)) mesh = {};
  return mesh;
}

// Vertices with the given coordinate within a hair of `value`.
inline std::vector<VertexId> vertices_on_plane(const TetMesh& mesh, int axis, double value) {
  std::vector<VertexId> ids;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (std::abs(mesh.vertices[v][axis] - value) < 1e-9) ids.push_back(static_cast<VertexId>(v));
  return ids;
}

}  // namespace tremolo::testing
