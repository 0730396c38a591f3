// The bytes in which a child process hands a surface to its parent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/file/printable_text.h"
#include "formats/surface/surface_reader.h"

namespace tremolo {

constexpr std::size_t kLongestMessage = 1024;

// SurfaceFile as it is, coordinates in the file's unit; or the one line that says why not.
std::vector<std::byte> encode_surface(const SurfaceFile& file);
std::vector<std::byte> encode_refusal(std::string_view message);

// Decodes the surface, or the error, of kind kContent, with its message. The bytes are untrusted:
// the result satisfies the conditions of render_surface.h, all numbers are finite, all names
// printable and there is at least one triangle. Memory is bounded by the number of bytes.
Result<SurfaceFile> decode_surface(std::span<const std::byte> bytes);

// Reads a file of any of assimp's formats as a SurfaceFile. Runs in a child process: assimp may
// crash, hang or use unlimited memory.

// Coordinates are in the file's unit; metres_per_unit and unit are those of the file. bytes: limit
// for the surface, since a scene may use one mesh any number of times. Errors: kContent, without
// the path. May throw exceptions of assimp, and does not free assimp's memory.
Result<SurfaceFile> import_surface(const std::string& path, std::uint64_t bytes);

}  // namespace tremolo
