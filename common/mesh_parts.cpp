#include "common/mesh_parts.h"

#include <algorithm>
#include <numeric>

namespace tremolo {
namespace {

// The smallest vertex of the part, by union-find with path halving.
VertexId root_of(std::vector<VertexId>& parent, VertexId id) {
  while (parent[id] != id) {
    parent[id] = parent[parent[id]];
    id = parent[id];
  }
  return id;
}

}  // namespace

MeshParts mesh_parts(const TetMesh& mesh) {
  std::vector<VertexId> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), VertexId{0});
  MeshParts parts;
  parts.part_of_vertex.assign(mesh.vertices.size(), -1);
  constexpr int kUsed = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    for (VertexId id : tet) {
      parts.part_of_vertex[id] = kUsed;
      const VertexId a = root_of(parent, tet[0]);
      const VertexId b = root_of(parent, id);
      parent[std::max(a, b)] = std::min(a, b);
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
