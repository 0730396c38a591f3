// Meshes put together from others that meet at vertices.
#pragma once

#include "tests/support/meshes/box_mesh.h"

namespace tremolo::testing {

// Adds `other`, moved by `offset`; vertices at the same position become one.
inline void join(TetMesh& mesh, const TetMesh& other, const Eigen::Vector3d& offset) {
  std::vector<VertexId> ids;
  for (const Eigen::Vector3d& x : other.vertices) {
    const Eigen::Vector3d moved = x + offset;
    const auto found =
        std::find_if(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const Eigen::Vector3d& vertex) { return (vertex - moved).norm() < 1e-9; });
    ids.push_back(static_cast<VertexId>(found - mesh.vertices.begin()));
    if (found == mesh.vertices.end()) mesh.vertices.push_back(moved);
  }
  for (const Tetrahedron& tet : other.tetrahedra)
    mesh.tetrahedra.push_back({ids[tet[0]], ids[tet[1]], ids[tet[2]], ids[tet[3]]});
}

// Adds `other`, moved by `offset`; it is connected to nothing.
inline void add_apart(TetMesh& mesh, const TetMesh& other, const Eigen::Vector3d& offset) {
  const auto first = static_cast<VertexId>(mesh.vertices.size());
  for (const Eigen::Vector3d& x : other.vertices) mesh.vertices.emplace_back(x + offset);
  for (Tetrahedron tet : other.tetrahedra) {
    for (VertexId& v : tet) v += first;
    mesh.tetrahedra.push_back(tet);
  }
}

// Cubes of a tenth of a metre at these positions of a grid, cells x cells x cells each.
inline TetMesh cubes(const std::vector<std::array<int, 3>>& places, int cells = 1) {
  TetMesh mesh;
  const TetMesh cube = box_mesh({cells, cells, cells}, {0.1, 0.1, 0.1});
  for (const auto& [i, j, k] : places) join(mesh, cube, {0.1 * i, 0.1 * j, 0.1 * k});
  return mesh;
}

}  // namespace tremolo::testing
