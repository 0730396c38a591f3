// Boxes whose mesh has the symmetry of the box.
#pragma once

#include <array>
#include <map>

#include "common/mesh/tet_mesh.h"

namespace tremolo::testing {

// A box centred at the origin, of cells cut into 24 tetrahedra each: the centre of the cell, the
// centre of a face and an edge of that face. cells: along x, y, z; size: of the box, m.
inline TetMesh symmetric_box(const std::array<int, 3>& cells, const Eigen::Vector3d& size) {
  TetMesh mesh;
  // Places in half cells, so that equal ones are equal numbers.
  std::map<std::array<int, 3>, VertexId> numbers;
  const auto vertex = [&](const std::array<int, 3>& place) {
    const auto [entry, added] = numbers.emplace(place, static_cast<VertexId>(mesh.vertices.size()));
    if (added) {
      Eigen::Vector3d x;
      for (int axis = 0; axis < 3; ++axis)
        x[axis] = size[axis] * (place[axis] - cells[axis]) / (2.0 * cells[axis]);
      mesh.vertices.push_back(x);
    }
    return entry->second;
  };
  const auto add_cell = [&](const std::array<int, 3>& centre) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (int side : {-1, 1}) {
        std::array<int, 3> face = centre;
        face[axis] += side;
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        constexpr int kCorners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        for (int corner = 0; corner < 4; ++corner) {
          std::array<int, 3> a = face, b = face;
          a[u] += kCorners[corner][0], a[v] += kCorners[corner][1];
          b[u] += kCorners[(corner + 1) % 4][0], b[v] += kCorners[(corner + 1) % 4][1];
          Tetrahedron tet = {vertex(centre), vertex(face), vertex(a), vertex(b)};
          if (signed_volume(mesh, tet) < 0) std::swap(tet[2], tet[3]);
          mesh.tetrahedra.push_back(tet);
        }
      }
  };
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i) add_cell({2 * i + 1, 2 * j + 1, 2 * k + 1});
  return mesh;
}

}  // namespace tremolo::testing
