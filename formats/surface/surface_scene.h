// A file of any format that assimp reads -> SurfaceFile. Runs in a child process: assimp may crash,
// hang and take memory without end.
#pragma once

#include <cstdint>
#include <string>

#include "formats/surface/surface_reader.h"

namespace tremolo {

// Coordinates are in the file's unit; metres_per_unit and unit say what the file says of it.
// bytes: what the surface may take, since a scene may show one mesh any number of times. Errors:
// kContent, without the path. May throw what assimp throws. What assimp took is not given back.
Result<SurfaceFile> import_surface(const std::string& path, std::uint64_t bytes);

}  // namespace tremolo
