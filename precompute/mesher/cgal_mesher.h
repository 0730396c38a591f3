// Recipe -> tetrahedral mesh, by CGAL's Mesh_3.
#pragma once

#include "assets/recipes/recipe.h"
#include "common/result.h"
#include "common/tet_mesh.h"

namespace tremolo {

// Delaunay refinement of the implicit solid, then perturbation and exudation of slivers. The same
// recipe gives the same mesh. Errors: kContent if the solid is empty or not in one piece at the
// wanted size; kSolver if the mesher fails.
Result<TetMesh> mesh_recipe(const Recipe& recipe);

}  // namespace tremolo
