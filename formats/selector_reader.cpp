#include "formats/selector_reader.h"

#include <utility>
#include <variant>

#include "formats/selector_file.h"

namespace tremolo {

Result<std::vector<VertexId>> resolve_selector(const std::string& text, const TetMesh& mesh) {
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (auto* file = std::get_if<SelectFile>(&selector->choice)) {
    Result<std::vector<VertexId>> ids = read_id_list(file->path, mesh.vertices.size());
    if (!ids) return ids.error();
    file->ids = std::move(*ids);
  }
  return select_vertices(*selector, mesh);
}

}  // namespace tremolo
