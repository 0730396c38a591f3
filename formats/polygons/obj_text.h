// Wavefront's .obj as text -> PolygonMesh.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Reads v (followed by w or a colour), vt, vn, f, o, g, usemtl; counts p and l; skips the rest.
// Corners count from 1, or from the end if they are negative, and may name vertices that follow
// later in the file. An object is the part below an `o` or a `g` of one name. A backslash joins
// lines. A corner's vt or vn that does not exist is left out and noted. Errors (kContent, with
// `name` and line): something that is not a number, a corner that is not a vertex.
Result<PolygonMesh> parse_obj_polygons(std::string_view text, const std::string& name);

}  // namespace tremolo
