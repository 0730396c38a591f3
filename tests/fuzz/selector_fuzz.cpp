// Selectors as a user writes them, on a small mesh with a set and a vertex that nothing uses.
#include "common/mesh/selector.h"
#include "tests/fuzz/harness.h"
#include "tests/support/meshes/small_mesh.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  static const TetMesh mesh = [] {
    TetMesh made = testing::small_mesh();
    made.vertices.push_back({2, 2, 2});
    made.node_sets["foot"] = {0, 1, 2};
    made.node_sets["unused"] = {5};
    return made;
  }();
  const Result<Selector> selector = parse_selector(std::string(bytes));
  check_error(selector);
  if (!selector) return;
  const Result<std::vector<VertexId>> ids = select_vertices(*selector, mesh);
  check_error(ids);
  if (!ids) return;
  if (ids->empty() != std::holds_alternative<SelectNone>(selector->choice))
    finding("a selector that silently selects nothing");
  for (VertexId id : *ids)
    if (id < 0 || id > 4) finding("a selected vertex that belongs to no tetrahedron");
}
