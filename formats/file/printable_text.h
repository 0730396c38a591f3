// Text of files that is shown to people.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tremolo {

// What stands for a name or a message whatever it was before: UTF-8 without control characters, of
// at most `bytes` bytes; what is neither becomes '?' or a blank.
std::string printable_text(std::string_view text, std::size_t bytes);
// Whether it is that already.
bool is_printable_text(std::string_view text, std::size_t bytes);

constexpr std::size_t kLongestName = 256;
}  // namespace tremolo
