// Geomview's .off -> PolygonMesh.
#pragma once

#include <string_view>

#include "common/result.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {

// A vertex whose faces have several colours becomes one vertex for each. Errors: those of
// parse_off(), and kContent for a file without faces; without a file name.
Result<PolygonMesh> parse_off_polygons(std::string_view text);

}  // namespace tremolo
