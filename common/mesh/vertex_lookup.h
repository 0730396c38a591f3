// From a vertex's id to its row.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The index of `id` in `ids`, which ascend without repeats; nullopt if it is not among them.
inline std::optional<std::size_t> find_vertex(const std::vector<VertexId>& ids, VertexId id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  if (at == ids.end() || *at != id) return std::nullopt;
  return at - ids.begin();
}

}  // namespace tremolo
