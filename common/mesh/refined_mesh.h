// Uniform refinement: each tetrahedron into eight.
#pragma once

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The vertices of a mesh with edge points (edge_points.h) as corners of eight times as many
// tetrahedra: four at the corners, four around the shortest diagonal of the octahedron between.
// Those of tetrahedron t are 8t .. 8t+7, positively oriented, in its region. Vertices and sets keep
// their numbers; the result is linear, without edges.
TetMesh refined_mesh(const TetMesh& mesh);

}  // namespace tremolo
