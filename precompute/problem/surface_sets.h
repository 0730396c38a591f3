// What an author painted and named on a surface -> colours and sets of the mesh's vertices.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Each vertex on the mesh's boundary looks at the point of the surface that is nearest to it: it
// takes its colour (if the surface has colours and the mesh has none; vertices inside stay bare),
// and joins the sets named after that triangle's object and material. An object or material that is
// nearest to no vertex gets those that are nearest to its own vertices. Names that are sets of the
// mesh already keep what they have. Returns notes for the user.
std::vector<std::string> add_surface_sets(const RenderSurface& surface, TetMesh& mesh);

}  // namespace tremolo
