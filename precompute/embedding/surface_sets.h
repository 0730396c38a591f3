// Transfers colours and names from a surface to colours and node sets of the mesh.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Each boundary vertex of the mesh takes the colour of the closest point on the surface (if the
// surface has colours and the mesh has none; interior vertices get none) and joins the node sets
// named after that triangle's object and material. An object or material that is closest to no
// vertex gets the mesh vertices closest to its own. Existing sets of the mesh are not changed.
// Returns notes for the user.
std::vector<std::string> add_surface_sets(const RenderSurface& surface, TetMesh& mesh);

}  // namespace tremolo
