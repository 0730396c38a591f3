// An .stl file, as text or in bytes -> PolygonMesh: three vertices of its own for each triangle.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// Text: keywords in any case, numbers and lines spread as the writer likes, a name to the end of
// its line with its blanks; each solid is an object. Bytes, whether or not they begin with "solid":
// one object, colours of VisCAM and Materialise; bytes behind the last triangle are noted. Errors
// (kContent, with `name` and line or byte): a file that is neither, or that ends too soon.
Result<PolygonMesh> parse_stl_polygons(std::string_view bytes, const std::string& name);

}  // namespace tremolo
