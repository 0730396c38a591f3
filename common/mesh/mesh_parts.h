// The parts of a mesh that are not connected.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// part_of_vertex: n labels, -1 for vertices of no tetrahedron; parts are connected through shared
// vertices and numbered by their smallest vertex.
struct MeshParts {
  std::size_t count = 0;
  std::vector<int> part_of_vertex;
};

// Indices must be in range.
MeshParts mesh_parts(const TetMesh& mesh);

}  // namespace tremolo
