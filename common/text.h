// Text for people: numbers, messages, and what a terminal may be shown.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

namespace tremolo {

// Decimal numbers to and from text as std::to_chars and std::from_chars do it, also with a standard
// library that has neither for floating point.

#ifdef __cpp_lib_to_chars

inline std::from_chars_result read_decimal(const char* first, const char* last, double& value) {
  return std::from_chars(first, last, value);
}
// Six digits, with an exponent where that is shorter; returns the end.
inline char* write_decimal(char* first, char* last, double value) {
  return std::to_chars(first, last, value, std::chars_format::general, 6).ptr;
}

#else

inline char* write_decimal(char* first, char* last, double value) {
  return first + std::snprintf(first, static_cast<std::size_t>(last - first), "%.6g", value);
}

// Blanks, a plus and hexadecimal digits, which strtod accepts, are refused.
inline std::from_chars_result read_decimal(const char* first, const char* last, double& value) {
  const std::string text(first, last);
  if (text.empty() || std::string_view("+ \t\n\r\f\v").find(text[0]) != std::string_view::npos)
    return {first, std::errc::invalid_argument};
  const std::size_t sign = text[0] == '-' ? 1 : 0;
  if (text.size() > sign + 1 && (text[sign + 1] == 'x' || text[sign + 1] == 'X')) {
    value = 0.0;
    return {first + sign + 1, std::errc{}};
  }
  char* stop = nullptr;
  const double found = std::strtod(text.c_str(), &stop);
  if (stop == text.c_str()) return {first, std::errc::invalid_argument};
  const char* end = first + (stop - text.c_str());
  const bool out = found > 1.7976931348623157e308 || found < -1.7976931348623157e308;
  if (out && text.find_first_of("iI") == std::string::npos)
    return {end, std::errc::result_out_of_range};
  value = found;
  return {end, std::errc{}};
}

#endif

// A number as an error message shows it. Six digits, with an exponent where that is shorter:
// "0.003", "1e-300", "nan".
inline std::string number_text(double value) {
  std::array<char, 32> text;
  return {text.data(), write_decimal(text.data(), text.data() + text.size(), value)};
}

// printf into a string of up to 399 bytes; longer text is cut.
template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof(buffer), format, values...);
  return buffer;
}

// A to Z become a to z; every other byte stays.
inline std::string lower_case(std::string_view letters) {
  std::string result(letters);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c += 'a' - 'A';
  return result;
}

// a to z become A to Z; every other byte stays.
inline std::string upper_case(std::string_view letters) {
  std::string result(letters);
  for (char& c : result)
    if (c >= 'a' && c <= 'z') c -= 'a' - 'A';
  return result;
}

// The text without blanks, tabs and line ends at its ends.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

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
