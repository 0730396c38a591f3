// Polygons as a file has them -> RenderSurface.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Vertices keep the file's order and numbers, also those without a triangle. One whose corners have
// several normals or texture coordinates gets copies for all but the first, behind the file's
// vertices; RenderSurface::sources is the way back. A vertex that is not finite keeps its number
// and is put where the first finite one is; its triangles are left out. Appends notes for the user.
RenderSurface render_surface_of(PolygonMesh mesh, std::vector<std::string>& notes);

}  // namespace tremolo
