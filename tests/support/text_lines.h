// Lines of a text file.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace tremolo::testing {

// Those that begin with the keyword and a blank.
inline std::vector<std::string> lines_with(const std::string& text, const std::string& keyword) {
  std::vector<std::string> found;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(keyword + " ")) found.push_back(line);
  return found;
}

// All of them, without their ends.
inline std::vector<std::string> all_lines(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) found.push_back(line);
  return found;
}

}  // namespace tremolo::testing
