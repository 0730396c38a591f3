// Reads a file of any of assimp's formats as a SurfaceFile. Runs in a child process: assimp may
// crash, hang or use unlimited memory.
#pragma once

#include <cstdint>
#include <string>

#include "formats/surface/surface_reader.h"

namespace tremolo {

// Coordinates are in the file's unit; metres_per_unit and unit are those of the file. bytes: limit
// for the surface, since a scene may use one mesh any number of times. Errors: kContent, without
// the path. May throw exceptions of assimp, and does not free assimp's memory.
Result<SurfaceFile> import_surface(const std::string& path, std::uint64_t bytes);

}  // namespace tremolo
