#include "formats/basis/light_basis.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace tremolo {

namespace {

// Removes the points that `number` gives no number, and the inner vertices. has_load: the default
// load remains.
template <class Number>
LocalResponse renumbered(const LocalResponse& response, const Number& number, bool has_load) {
  LocalResponse kept;
  std::vector<Eigen::Index> columns;
  for (std::size_t place = 0; place < response.at.size(); ++place) {
    std::optional<VertexId> at = kAtDefaultLoad;
    if (response.at[place] != kAtDefaultLoad)
      at = number(response.at[place]);
    else if (!has_load)
      at.reset();
    if (!at) continue;
    kept.at.push_back(*at);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      columns.push_back(3 * static_cast<Eigen::Index>(place) + axis);
  }
  if (kept.at.empty()) return kept;
  kept.surface = response.surface(Eigen::all, columns);
  kept.render =
      response.render.size() > 0 ? BasisRows(response.render(Eigen::all, columns)) : BasisRows();
  kept.interior.resize(0, std::ssize(columns));
  return kept;
}

}  // namespace

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
  data.response = renumbered(data.response, number, !data.load.vertices.empty());
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
