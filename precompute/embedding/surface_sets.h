// Transfers colours, names and numbers of a surface to the mesh.
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

// Sets mesh.solids: each tetrahedron belongs to the object, and to the material, in whose triangles
// its centroid is (the smallest of several), or else to that of the triangle next to it. Names of
// node sets that exist already are left out.
void add_solids(const RenderSurface& surface, TetMesh& mesh);

// Sets mesh.given for a mesh that was cut from the surface.
void add_given_vertices(const RenderSurface& surface, TetMesh& mesh);

}  // namespace tremolo
