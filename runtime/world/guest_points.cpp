#include "runtime/world/guest_points.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include "common/mesh/selector.h"
#include "formats/basis/selector_reader.h"
#include "runtime/bodies/cloth/cloth_places.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

std::string key_text(const char* key, const std::string& text) {
  return std::string(key) + " = \"" + text + "\"";
}

std::optional<VertexId> whole_vertex(const std::string& text) {
  VertexId vertex = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, vertex);
  return stop == end && code == std::errc{} ? std::optional(vertex) : std::nullopt;
}

// The numbers of a `file:` are read here.
Status read_files(Selector& selector, std::size_t vertices) {
  if (auto* file = std::get_if<SelectFile>(&selector.choice))
    if (Status s = take(file->ids, read_id_list(file->path, vertices)); !s) return s;
  for (Selector& other : selector.further)
    if (Status s = read_files(other, vertices); !s) return s;
  return Success{};
}

// Vertices of the surface of a body of tetrahedra.
Result<std::vector<VertexId>> tets_vertices(const TetStep& step, const std::string& text) {
  const TetModel& model = step.body().model();
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (Status s = read_files(*selector, model.vertices()); !s) return s.error();
  std::map<std::string, std::vector<VertexId>> sets;
  std::vector<bool> outside(model.nodes(), false);
  for (std::size_t v = 0; v < model.vertices(); ++v) {
    if (!step.point_of(static_cast<VertexId>(v))) continue;
    outside[v] = true;
    if (model.held()[v] != 0) sets["fixed"].push_back(static_cast<VertexId>(v));
  }
  return select_vertices(*selector, {model.mesh().vertices, std::move(outside), sets,
                                     model.mesh().colours, "inside the body"});
}

Result<std::vector<VertexId>> cloth_vertices(const ClothStep& step, const std::string& text) {
  const ClothBody& body = step.body();
  std::vector<std::size_t> particles;
  if (Status s = add_cloth_place(body.cloth(), &body.model().parts(), text, particles); !s)
    return s.error();
  return std::vector<VertexId>(particles.begin(), particles.end());
}

// Particles by a selector.
Result<std::vector<VertexId>> cloth_selection(const ClothStep& step, const std::string& text) {
  const ClothParts& parts = step.body().model().parts();
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (Status s = read_files(*selector, parts.vertices()); !s) return s.error();
  std::vector<Vector3d> places(parts.vertices());
  for (std::size_t v = 0; v < places.size(); ++v)
    places[v] = step.start_of(parts.particle_of_vertex(v));
  const std::map<std::string, std::vector<VertexId>> sets;
  const std::vector<Colour> colours;
  return select_vertices(*selector,
                         {places, std::vector<bool>(places.size(), true), sets, colours, ""});
}

Result<VertexId> one_vertex(const MixedGuests& guests, std::size_t guest, const std::string& text,
                            const char* key, const char* holder) {
  // A number may be that of a vertex inside, which has its own error.
  if (const std::optional<VertexId> number = whole_vertex(text)) return *number;
  const ClothStep* cloth = guests.cloth(guest);
  const Result<std::vector<VertexId>> found =
      cloth != nullptr ? cloth_vertices(*cloth, text) : tets_vertices(*guests.tets(guest), text);
  if (!found) return content_error(key_text(key, text) + ": " + found.error().message);
  if (found->size() != 1)
    return content_error(key_text(key, text) + " is " + std::to_string(found->size()) +
                         (cloth != nullptr ? " particles, a " : " vertices, a ") + holder +
                         " holds one: near:X,Y,Z takes the nearest");
  return found->front();
}

}  // namespace

Result<std::size_t> guest_point(const MixedGuests& guests, std::size_t guest,
                                const std::string& text, const char* key, const char* holder) {
  const Result<VertexId> vertex = one_vertex(guests, guest, text, key, holder);
  if (!vertex) return vertex.error();
  const Result<std::size_t> point = guests.point_of_vertex(guest, *vertex);
  if (!point) return content_error(key_text(key, text) + ": " + point.error().message);
  return *point;
}

Result<std::vector<std::size_t>> guest_points(const MixedGuests& guests, std::size_t guest,
                                              const std::string& text, const char* key) {
  const auto failed = [&](const Error& error) {
    return content_error(key_text(key, text) + ": " + error.message);
  };
  std::vector<std::size_t> points;
  if (const TetStep* tets = guests.tets(guest)) {
    const Result<std::vector<VertexId>> found = tets_vertices(*tets, text);
    if (!found) return failed(found.error());
    points = tets->points_on(*found);
  } else {
    const ClothStep& cloth = *guests.cloth(guest);
    Result<std::vector<VertexId>> found = cloth_vertices(cloth, text);
    if (!found) {
      const Result<std::vector<VertexId>> selected = cloth_selection(cloth, text);
      // Places have no comparisons and no boxes: a text with these was meant as a selector.
      const bool selects =
          text.find_first_of("<>") != std::string::npos || text.starts_with("box:");
      if (!selected) return failed(selects ? selected.error() : found.error());
      found = *selected;
    }
    const ClothParts& parts = cloth.body().model().parts();
    for (const VertexId vertex : *found)
      points.push_back(parts.particle_of_vertex(static_cast<std::size_t>(vertex)));
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
  }
  if (points.empty())
    return content_error(key_text(key, text) + " is no point of its surface: a weld needs some");
  return points;
}

}  // namespace tremolo
