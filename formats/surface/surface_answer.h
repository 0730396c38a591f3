// The bytes in which a child process hands a surface to its parent.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/surface/surface_reader.h"

namespace tremolo {

// What stands for a name or a message whatever it was before: UTF-8 without control characters, of
// at most `bytes` bytes; what is neither becomes '?' or a blank.
std::string printable_text(std::string_view text, std::size_t bytes);
// Whether it is that already.
bool is_printable_text(std::string_view text, std::size_t bytes);

constexpr std::size_t kLongestName = 256;
constexpr std::size_t kLongestMessage = 1024;

// SurfaceFile as it is, coordinates in the file's unit; or the one line that says why not.
std::vector<std::byte> encode_surface(const SurfaceFile& file);
std::vector<std::byte> encode_refusal(std::string_view message);

// The surface of such bytes, or an error of kind kContent with the message. Nothing in them is
// trusted: what comes out keeps what render_surface.h promises, all numbers are finite, all names
// printable and there is at least one triangle. Memory is bounded by the number of bytes.
Result<SurfaceFile> decode_surface(std::span<const std::byte> bytes);

}  // namespace tremolo
