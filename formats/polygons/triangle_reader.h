// The polygons and triangles of an .obj or .ply file, without assimp.
#pragma once

#include <string>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Errors: kSystem for a file that cannot be read; kUsage for another ending; those of
// parse_obj_polygons() and parse_ply_polygons().
Result<PolygonMesh> read_polygons(const std::string& path);

// Only positions and triangles, in the file's order. Errors also those of triangles_of().
Result<SurfaceMesh> read_surface_triangles(const std::string& path);

}  // namespace tremolo
