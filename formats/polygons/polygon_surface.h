// Polygons as a file has them -> RenderSurface.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Vertices keep the file's order and numbers, also those without a triangle. A vertex whose corners
// have several normals or texture coordinates gets copies for all but the first, after the file's
// vertices; RenderSurface::sources maps them back. A vertex that is not finite keeps its number and
// gets the position of the first finite one; its triangles are left out. Appends notes for the
// user.
RenderSurface render_surface_of(PolygonMesh mesh, std::vector<std::string>& notes);

}  // namespace tremolo
