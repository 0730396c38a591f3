#include "formats/basis/selector_reader.h"

#include <utility>
#include <variant>

#include "formats/basis/selector_file.h"

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

Result<std::vector<VertexId>> resolve_selector(const std::string& text, const TetMesh& mesh) {
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (Status s = fill(*selector, mesh.vertices.size()); !s) return s.error();
  for (Selector& other : selector->further)
    if (Status s = fill(other, mesh.vertices.size()); !s) return s.error();
  return select_vertices(*selector, mesh);
}

std::vector<std::string> near_notes(const std::string& text, const TetMesh& mesh) {
  std::vector<std::string> notes;
  if (text.find("near:") == std::string::npos) return notes;
  const Result<Selector> selector = parse_selector(text);
  if (!selector) return notes;
  for (const NearChoice& choice : near_choices(*selector, selection_space(mesh)))
    notes.push_back(describe_near(choice, choice.nearest));
  return notes;
}

}  // namespace tremolo
