#include "runtime/scene/selection.h"

#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "common/mesh/selector.h"
#include "common/mesh/surface_mesh.h"
#include "formats/basis/selector_reader.h"

namespace tremolo {
namespace {

using Sets = std::map<std::string, std::vector<VertexId>>;

// The vertex's index in the boundary's block, which replaces its id while a selector is resolved.
std::optional<VertexId> place_of(const VertexBlock& block, VertexId id) {
  const std::optional<std::size_t> at = find_vertex(block.vertex_ids, id);
  return at ? std::optional(static_cast<VertexId>(*at)) : std::nullopt;
}

void add_to(Sets& sets, const std::string& name, const VertexBlock& block, VertexId id) {
  if (const std::optional<VertexId> place = place_of(block, id)) sets[name].push_back(*place);
}

// All sets as indices into the block, as the whole selection until it is finished.
Sets make_sets(const Boundary& boundary) {
  const VertexBlock& block = boundary.surface;
  Sets sets;
  if (boundary.render != nullptr) {
    const RenderSurface& surface = boundary.render->surface;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      for (const VertexId corner : surface.triangles[t]) {
        const VertexId anchor = boundary.render->anchors[corner];
        add_to(sets, surface.objects[surface.object_of[t]], block, anchor);
        add_to(sets, surface.materials[surface.material_of[t]], block, anchor);
      }
  }
  for (std::size_t v = 0; v < block.vertex_ids.size(); ++v)
    if (block.rows.middleRows(3 * v, 3).isZero(0.0))
      sets["fixed"].push_back(static_cast<VertexId>(v));
  for (const VertexId id : boundary.load.vertices) add_to(sets, "loaded", block, id);
  return sets;
}

std::vector<Colour> make_colours(const Boundary& boundary) {
  if (boundary.render == nullptr || boundary.render->surface.colours.empty()) return {};
  std::vector<Colour> colours(boundary.surface.vertex_ids.size());
  for (std::size_t v = 0; v < boundary.render->anchors.size(); ++v)
    if (const auto place = place_of(boundary.surface, boundary.render->anchors[v]))
      colours[*place] = boundary.render->surface.colours[v];
  return colours;
}

// Converts the ids in a selector to indices.
Status localise(Selector& selector, const Boundary& boundary) {
  if (auto* list = std::get_if<SelectVertices>(&selector.choice))
    for (VertexId& id : list->ids) {
      const std::optional<VertexId> place = place_of(boundary.surface, id);
      if (!place)
        return content_error("selector `" + selector.text + "`: vertex " + std::to_string(id) +
                             " is not on the boundary of the model");
      id = *place;
    }
  if (auto* file = std::get_if<SelectFile>(&selector.choice)) {
    const auto ids = read_id_list(file->path, boundary.vertex_count);
    if (!ids) return ids.error();
    for (const VertexId id : *ids)
      if (const auto place = place_of(boundary.surface, id)) file->ids.push_back(*place);
  }
  return Success{};
}

}  // namespace

Result<Selection> select_on_boundary(const std::string& text, const Boundary& boundary) {
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (Status s = localise(*selector, boundary); !s) return s.error();
  for (Selector& other : selector->further)
    if (Status s = localise(other, boundary); !s) return s.error();
  const Sets sets = make_sets(boundary);
  const std::vector<Colour> colours = make_colours(boundary);
  const VertexBlock& block = boundary.surface;
  const SelectionSpace space = {block.rest, std::vector<bool>(block.rest.size(), true), sets,
                                colours, ""};
  const Result<std::vector<VertexId>> places = select_vertices(*selector, space);
  if (!places) return places.error();
  Selection selection;
  for (const VertexId place : *places) {
    selection.ids.push_back(block.vertex_ids[place]);
    selection.places.push_back(block.rest[place]);
  }
  for (const NearChoice& choice : near_choices(*selector, space))
    selection.notes.push_back(describe_near(choice, block.vertex_ids[choice.nearest]));
  return selection;
}

std::vector<std::string> nearest_of(const std::string& text, const Model& model) {
  if (text.find("near:") == std::string::npos) return {};
  Result<Selection> chosen = select_on_boundary(
      text, {model.surface(), model.render(), model.default_load(), model.vertex_count()});
  return chosen ? std::move(chosen->notes) : std::vector<std::string>{};
}

Result<std::vector<VertexId>> vertices_of(const std::string& text, const Model& model) {
  VertexId vertex = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, vertex);
  if (stop == end && code == std::errc{}) {
    if (vertex < 0) return content_error("vertex " + text + " must not be negative");
    return std::vector<VertexId>{vertex};
  }
  // A number may be that of a vertex inside, however it is written.
  if (const Result<Selector> selector = parse_selector(text); selector && selector->further.empty())
    if (const auto* list = std::get_if<SelectVertices>(&selector->choice)) return list->ids;
  Result<Selection> chosen = select_on_boundary(
      text, {model.surface(), model.render(), model.default_load(), model.vertex_count()});
  if (!chosen) return chosen.error();
  return std::move(chosen->ids);
}

DefaultLoad shared_by_area(const std::vector<VertexId>& vertices, const Eigen::Vector3d& force,
                           const Model& model) {
  DefaultLoad load{vertices, {}};
  if (vertices.empty()) return load;
  for (const double share :
       area_shares(vertices, model.surface().vertex_ids, model.triangles(), model.surface().rest))
    load.forces.push_back(share * force);
  return load;
}

}  // namespace tremolo
