// printf into a string, for reports and messages: up to 399 bytes, what is longer is cut.
#pragma once

#include <cstdio>
#include <string>

namespace tremolo {

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof(buffer), format, values...);
  return buffer;
}

}  // namespace tremolo
