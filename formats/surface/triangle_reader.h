// The triangles of an .obj or .ply file, for those who do without assimp.
#pragma once

#include <string>
#include <string_view>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

// Positions and faces alone, in the file's order; polygons are cut into fans from their first
// corner. Read are Wavefront's .obj (v, f; corners counted from the end too) and .ply as text or in
// bytes of either order. Errors: kSystem for a file that cannot be read; kUsage for another ending;
// kContent, naming file and line or byte: what is no number or not finite, a corner that is no
// vertex or stands twice in a face, a face of fewer than three corners, an end that comes too soon.
Result<SurfaceMesh> read_surface_triangles(const std::string& path);

// The same of texts in memory; `name` stands in messages.
Result<SurfaceMesh> parse_obj(std::string_view text, const std::string& name);
Result<SurfaceMesh> parse_ply(std::string_view bytes, const std::string& name);

}  // namespace tremolo
