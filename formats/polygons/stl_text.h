// Reads an .stl file, text or binary, as a PolygonMesh with three vertices for each triangle.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Text: keywords in any case, numbers and lines in any layout, a name with blanks up to the end of
// its line; each solid is an object. Binary, also if it begins with "solid": one object, colours of
// VisCAM and Materialise; bytes after the last triangle are noted. Errors (kContent, with `name`
// and line or byte): a file of neither form, or an early end.
Result<PolygonMesh> parse_stl_polygons(std::string_view bytes, const std::string& name);

}  // namespace tremolo
