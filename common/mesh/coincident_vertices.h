// Vertices at one position: parts of a mesh that were meshed or written separately have the nodes
// of their common faces twice.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Vertices of tetrahedra (edge points included) are at one position if they are within this
// fraction of the mesh's diagonal, and within a thousandth of the shortest edge: this includes
// coordinates written with seven digits.
inline constexpr double kCoincident = 1e-6;

// Vertices at the position of another.
struct Coincidences {
  std::size_t pairs = 0;           // vertices at the position of one with a lower number
  std::vector<VertexId> first_at;  // for each vertex the lowest at its position, or itself
};

// Indices of the mesh that do not exist are passed over: check_mesh() names them.
Coincidences find_coincidences(const TetMesh& mesh);

// Makes tetrahedra, edges and sets refer to the lowest of the vertices at one position; the others
// stay, in no tetrahedron, so that all numbers are the file's.
void merge_vertices(const Coincidences& found, TetMesh& mesh);

}  // namespace tremolo
