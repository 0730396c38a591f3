// The tetrahedra on both sides of each face.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Face f of a positively oriented tetrahedron, opposite to corner f, counter-clockwise from
// outside.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

inline Triangle tet_face(const Tetrahedron& tet, std::size_t face) {
  return {tet[kTetFaces[face][0]], tet[kTetFaces[face][1]], tet[kTetFaces[face][2]]};
}

// Calls visit(sides) once for each face of the mesh; sides: 4 t + f for every tetrahedron t that
// has it, as its face f, ascending: one on the boundary, two inside.
template <class Visit>
void for_each_face(const TetMesh& mesh, const Visit& visit) {
  struct Face {
    VertexId b, c;  // next to the smallest vertex, ascending
    std::size_t side;
  };
  const auto sorted = [&](std::size_t side) {
    Triangle face = tet_face(mesh.tetrahedra[side / 4], side % 4);
    std::sort(face.begin(), face.end());
    return face;
  };
  // Faces with the same smallest vertex are adjacent: short lists to sort.
  const std::size_t sides = 4 * mesh.tetrahedra.size();
  std::vector<std::size_t> start(mesh.vertices.size() + 1, 0);
  for (std::size_t side = 0; side < sides; ++side) ++start[sorted(side)[0] + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::size_t> end = start;
  std::vector<Face> faces(sides);
  for (std::size_t side = 0; side < sides; ++side) {
    const auto [a, b, c] = sorted(side);
    faces[end[a]++] = {b, c, side};
  }
  std::vector<std::size_t> same;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::span<Face> list(faces.data() + start[v], end[v] - start[v]);
    std::sort(list.begin(), list.end(), [](const Face& x, const Face& y) {
      return std::array{x.b, x.c} != std::array{y.b, y.c}
                 ? std::array{x.b, x.c} < std::array{y.b, y.c}
                 : x.side < y.side;
    });
    for (std::size_t i = 0; i < list.size();) {
      same.clear();
      const Face& first = list[i];
      for (; i < list.size() && list[i].b == first.b && list[i].c == first.c; ++i)
        same.push_back(list[i].side);
      visit(std::span<const std::size_t>(same));
    }
  }
}

}  // namespace tremolo
