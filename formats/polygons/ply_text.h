// A .ply file, as text or in bytes of either order -> PolygonMesh.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Elements may be in any order, and unknown ones are skipped, with or without lists. Reads vertices
// with normals, texture coordinates and colours, faces with texture coordinates of their corners,
// and triangle strips. Errors (kContent, with `name`): those of the header, an early end, something
// that is not a number, a corner that is not a vertex.
Result<PolygonMesh> parse_ply_polygons(std::string_view bytes, const std::string& name);

}  // namespace tremolo
