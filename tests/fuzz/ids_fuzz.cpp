// Lists of vertex ids, the files of `file:` selectors.
#include <algorithm>

#include "formats/basis/selector_reader.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  constexpr std::size_t kVertices = 1000;
  const Result<std::vector<VertexId>> ids = parse_id_list(bytes, "input.txt", kVertices);
  check_error(ids);
  if (!ids) return;
  if (ids->empty() || !std::is_sorted(ids->begin(), ids->end()) || ids->front() < 0 ||
      static_cast<std::size_t>(ids->back()) >= kVertices)
    finding("ids that are empty, out of order or out of range");
}
