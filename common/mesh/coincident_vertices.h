// Vertices that lie at one place: the parts of a mesh that were meshed or written separately have
// the nodes of their common faces twice.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Vertices of tetrahedra (edge points included) that lie within this fraction of the mesh's
// diagonal of each other, but within a thousandth of the shortest edge in any case, are at one
// place: coordinates written with seven digits are.
inline constexpr double kCoincident = 1e-6;

// pairs: how many vertices lie where one of a lower number lies. first_at: of each vertex the
// lowest at its place; itself for all others.
struct Coincidences {
  std::size_t pairs = 0;
  std::vector<VertexId> first_at;
};

// Indices of the mesh that do not exist are passed over: check_mesh() names them.
Coincidences find_coincidences(const TetMesh& mesh);

// Of vertices at one place the tetrahedra, edges and sets refer to the lowest afterwards; the
// others stay, in no tetrahedron, so that all numbers are the file's.
void merge_vertices(const Coincidences& found, TetMesh& mesh);

}  // namespace tremolo
