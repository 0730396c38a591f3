// Lifts the smallest dihedral angles of a mesh by moving vertices.
#pragma once

#include <cstddef>

#include "assets/recipes/recipe.h"
#include "common/tet_mesh.h"

namespace tremolo {

// Moves the vertices of tetrahedra with a dihedral angle below `wanted` degrees, one at a time and
// only if the smallest angle of all tetrahedra around the vertex grows; vertices of the boundary
// stay on the recipe's surface. The mesh must be positively oriented and stays so. The same mesh
// gives the same result. Returns how many tetrahedra are still below.
std::size_t repair_slivers(TetMesh& mesh, const Recipe& recipe, double wanted);

}  // namespace tremolo
