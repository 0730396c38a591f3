#include "common/mesh/mesh_parts.h"

#include <numeric>

#include "common/mesh/union_find.h"

namespace tremolo {

MeshParts mesh_parts(const TetMesh& mesh) {
  std::vector<VertexId> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), VertexId{0});
  MeshParts parts;
  parts.part_of_vertex.assign(mesh.vertices.size(), -1);
  constexpr int kUsed = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    for (VertexId id : tet) {
      parts.part_of_vertex[id] = kUsed;
      join_sets(parent, tet[0], id);
    }
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (parts.part_of_vertex[v] != kUsed) continue;
    // The root is the smallest vertex of its part, so it has its label before the others ask.
    const VertexId root = root_of(parent, static_cast<VertexId>(v));
    parts.part_of_vertex[v] = root == static_cast<VertexId>(v) ? static_cast<int>(parts.count++)
                                                               : parts.part_of_vertex[root];
  }
  return parts;
}

}  // namespace tremolo
