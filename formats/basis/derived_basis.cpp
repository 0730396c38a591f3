#include "formats/basis/derived_basis.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/packed_index.h"

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

namespace {

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}

void scale_rows(VertexBlock& block, double factor) {
  block.rows *= factor;
  block.column_scales *= factor;
}

// An entry of G belongs to two strain terms, each of which has one coordinate or two: d^-1/2 for
// each.
void scale_gram(std::vector<double>& gram, std::size_t r, double stiffness, double density) {
  if (gram.empty()) return;
  std::vector<int> degree(strain_terms(r), 2);
  for (std::size_t j = 0; j < r; ++j) degree[strain_index(j)] = 1;
  for (std::size_t b = 0; b < degree.size(); ++b)
    for (std::size_t a = 0; a <= b; ++a)
      gram[pair_index(a, b)] *= stiffness * std::pow(density, -0.5 * (degree[a] + degree[b]));
}

void scale_inertia(InertiaIntegrals& inertia, double density) {
  inertia.mass *= density;
  inertia.first_moment *= density;
  inertia.second_moment *= density;
  inertia.linear *= std::sqrt(density);
}

bool finite(const BasisData& data) {
  const auto good = [](double value) { return std::isfinite(value); };
  return data.lambda.allFinite() && (data.lambda.array() > 0.0).all() &&
         std::all_of(data.cubic.begin(), data.cubic.end(), good) &&
         std::all_of(data.quartic.begin(), data.quartic.end(), good) &&
         std::all_of(data.strain_gram.begin(), data.strain_gram.end(), good) &&
         data.surface.rows.allFinite() && data.interior.rows.allFinite() &&
         std::isfinite(data.total_mass) && data.total_mass > 0.0 &&
         data.response.surface.allFinite();
}

}  // namespace

Result<BasisData> rescaled(BasisData data, double stiffness, double density) {
  for (const double factor : {stiffness, density})
    if (!(factor > 0.0) || !std::isfinite(factor))
      return content_error(
          "the factors of stiffness and density must be positive and finite, found " +
          std::to_string(factor));
  const double rows = 1.0 / std::sqrt(density);
  data.total_mass *= density;
  data.lambda *= stiffness / density;
  scale(data.cubic, stiffness * rows / density);
  scale(data.quartic, stiffness / (density * density));
  scale_gram(data.strain_gram, static_cast<std::size_t>(data.lambda.size()), stiffness, density);
  scale_rows(data.surface, rows);
  scale_rows(data.interior, rows);
  if (data.render) {
    data.render->rows *= rows;
    data.render->column_scales *= rows;
  }
  if (data.inertia) scale_inertia(*data.inertia, density);
  scale(data.elements.masses, density);
  for (BasisRows* block : {&data.response.surface, &data.response.interior, &data.response.render})
    *block /= stiffness;
  data.vega = {};
  if (finite(data)) return data;
  return content_error("the rescaled model has numbers that are zero or too large");
}

}  // namespace tremolo
