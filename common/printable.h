#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tremolo {

// The number of bytes of the UTF-8 character at the front, 1 to 4; 0 if it is invalid, or controls
// a terminal or the direction of writing.
inline std::size_t plain_character(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  if (first < 0x80) return first >= ' ' && first != 0x7F ? 1 : 0;
  const std::size_t length = first >= 0xF0 && first < 0xF5   ? 4
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xC2 && first < 0xE0 ? 2
                                                             : 0;
  if (length == 0 || length > text.size()) return 0;
  std::uint32_t code = first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  const bool too_long = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool half = code >= 0xD800 && code <= 0xDFFF;
  const bool steers = code < 0xA0 || (code >= 0x200E && code <= 0x200F) ||
                      (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return too_long || half || steers || code > 0x10FFFF ? 0 : length;
}

// Text for a terminal: control characters, which names in files may contain, are printed as \x1b.
// Line ends, tabs, and a return at the very end are kept.
inline std::string printable(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    const bool stays = c == '\n' || c == '\t' || (c == '\r' && at + 1 == text.size());
    const std::size_t length = stays ? 1 : plain_character(text.substr(at));
    if (length > 0) {
      shown += text.substr(at, length);
      at += length;
      continue;
    }
    const auto byte = static_cast<std::uint8_t>(c);
    shown += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
    ++at;
  }
  return shown;
}

}  // namespace tremolo
