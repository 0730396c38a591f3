// Small text for reports, messages and comparisons.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace tremolo {

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

}  // namespace tremolo
