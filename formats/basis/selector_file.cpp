#include "formats/basis/selector_file.h"

#include <algorithm>
#include <cstdint>

#include "formats/file/text_scanner.h"
#include "formats/file/whole_file.h"

namespace tremolo {

Result<std::vector<VertexId>> read_id_list(const std::string& path, std::size_t vertex_count) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_id_list(*text, path, vertex_count);
}

Result<std::vector<VertexId>> parse_id_list(std::string_view text, const std::string& path,
                                            std::size_t vertex_count) {
  TextScanner scanner(text, path, {.comment = '#', .commas = true, .open_end = true});
  std::vector<VertexId> ids;
  while (!scanner.at_end()) {
    std::int64_t id = 0;
    if (!scanner.read(id, "a vertex id")) return scanner.error();
    if (id < 0 || static_cast<std::uint64_t>(id) >= vertex_count)
      return scanner.problem("expected a vertex id below " + std::to_string(vertex_count) +
                             " (ids count from 0), found " + std::to_string(id));
    ids.push_back(static_cast<VertexId>(id));
  }
  if (ids.empty()) return scanner.problem("expected vertex ids, found none");
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace tremolo
