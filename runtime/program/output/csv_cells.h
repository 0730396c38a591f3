// The cells of a line of a CSV file that has no quotes, as those that the programs write.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "formats/file/text_scanner.h"

namespace tremolo {

// The line without the return that Windows puts at its end.
inline std::string_view without_return(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

// One cell at least; the views are into `line`.
inline std::vector<std::string_view> cells_of(std::string_view line) {
  line = without_mark(without_return(line));
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    cells.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return cells;
}

}  // namespace tremolo
