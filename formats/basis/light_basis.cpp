#include "formats/basis/light_basis.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace tremolo {

Result<BasisData> without_interior(BasisData data) {
  const std::vector<VertexId> ids = std::exchange(data.surface.vertex_ids, {});
  const auto number = [&ids](VertexId id) -> std::optional<VertexId> {
    const auto found = std::lower_bound(ids.begin(), ids.end(), id);
    if (found == ids.end() || *found != id) return std::nullopt;
    return static_cast<VertexId>(found - ids.begin());
  };
  for (std::size_t i = 0; i < ids.size(); ++i)
    data.surface.vertex_ids.push_back(static_cast<VertexId>(i));
  const DefaultLoad load = std::exchange(data.load, {});
  for (std::size_t i = 0; i < load.vertices.size(); ++i)
    if (const auto vertex = number(load.vertices[i])) {
      data.load.vertices.push_back(*vertex);
      data.load.forces.push_back(load.forces[i]);
    }
  // A part of a load is another load.
  if (data.load.vertices.size() != load.vertices.size()) data.load = {};
  const std::vector<VertexId> fixed = std::exchange(data.fixed_vertices, {});
  for (const VertexId id : fixed)
    if (const auto vertex = number(id)) data.fixed_vertices.push_back(*vertex);
  data.fixed_vertex_count = data.fixed_vertices.size();
  if (data.render)
    for (VertexId& anchor : data.render->anchors) {
      const auto vertex = number(anchor);
      if (!vertex) return content_error("its render surface follows a vertex inside");
      anchor = *vertex;
    }
  data.vertex_count = ids.size();
  data.interior = {};
  data.interior.rows.resize(0, data.lambda.size());
  data.edges.clear();
  data.elements = {};
  return data;
}

}  // namespace tremolo
