#include "formats/basis/selector_reader.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <variant>

#include "common/packed_index.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

// Reads the ids of a `file:`.
Status fill(Selector& selector, std::size_t vertices) {
  auto* file = std::get_if<SelectFile>(&selector.choice);
  if (file == nullptr) return Success{};
  Result<std::vector<VertexId>> ids = read_id_list(file->path, vertices);
  if (!ids) return ids.error();
  file->ids = std::move(*ids);
  return Success{};
}

}  // namespace

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
    if (!is_index(id, vertex_count))
      return scanner.problem("expected a vertex id below " + std::to_string(vertex_count) +
                             " (ids count from 0), found " + std::to_string(id));
    ids.push_back(static_cast<VertexId>(id));
  }
  if (ids.empty()) return scanner.problem("expected vertex ids, found none");
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

Result<std::vector<VertexId>> resolve_selector(Selector selector, const TetMesh& mesh) {
  const std::size_t count = mesh.given ? mesh.given->count : mesh.vertices.size();
  if (Status s = fill(selector, count); !s) return s.error();
  for (Selector& other : selector.further)
    if (Status s = fill(other, count); !s) return s.error();
  return select_vertices(selector, mesh);
}

Result<std::vector<VertexId>> resolve_selector(const std::string& text, const TetMesh& mesh) {
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  return resolve_selector(std::move(*selector), mesh);
}

std::vector<std::string> near_notes(const Selector& selector, const TetMesh& mesh) {
  std::vector<std::string> notes;
  if (selector.text.find("near:") == std::string::npos) return notes;
  for (const NearChoice& choice : near_choices(selector, selection_space(mesh)))
    notes.push_back(describe_near(choice, choice.nearest));
  return notes;
}

}  // namespace tremolo
