// Text of files for display.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tremolo {

// Makes any bytes displayable as a name or a message: UTF-8 without control characters, at most
// `bytes` bytes; other bytes become '?' or a blank.
std::string printable_text(std::string_view text, std::size_t bytes);
// True if the text is already in that form.
bool is_printable_text(std::string_view text, std::size_t bytes);

constexpr std::size_t kLongestName = 256;
}  // namespace tremolo
