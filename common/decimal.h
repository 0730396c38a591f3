// Decimal numbers to and from text as std::to_chars and std::from_chars do it, also with a standard
// library that has neither for floating point.
#pragma once

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

namespace tremolo {

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

}  // namespace tremolo
