#include "runtime/world/guest_points.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "common/mesh/selector.h"
#include "common/mesh/surface_mesh.h"
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
    places[v] = step.body().cloth().named(step.start_of(parts.particle_of_vertex(v)));
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

// Particles by a place, else by a selector.
Result<std::vector<VertexId>> places_or_selection(const ClothStep& step, const std::string& text) {
  Result<std::vector<VertexId>> found = cloth_vertices(step, text);
  if (found) return found;
  Result<std::vector<VertexId>> selected = cloth_selection(step, text);
  if (selected) return selected;
  // Places have no comparisons and no boxes: a text with these was meant as a selector.
  const bool selects = text.find_first_of("<>") != std::string::npos || text.starts_with("box:");
  return selects ? selected : found;
}

std::vector<std::size_t> particles_of(const ClothStep& step,
                                      const std::vector<VertexId>& vertices) {
  const ClothParts& parts = step.body().model().parts();
  std::vector<std::size_t> particles;
  for (const VertexId vertex : vertices)
    particles.push_back(parts.particle_of_vertex(static_cast<std::size_t>(vertex)));
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  return particles;
}

// A force on these vertices, which are points.
std::vector<PointPush> shared_pushes(const TetStep& step, const std::vector<VertexId>& vertices,
                                     const Vector3d& force) {
  const TetModel& model = step.body().model();
  const BoundarySurface boundary = boundary_surface(model.mesh());
  std::vector<Vector3d> rest;
  for (const VertexId vertex : boundary.vertex_ids)
    rest.push_back(model.mesh().vertices[static_cast<std::size_t>(vertex)]);
  const std::vector<double> shares =
      area_shares(vertices, boundary.vertex_ids, boundary.triangles, rest);
  std::vector<PointPush> pushes;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (shares[i] != 0.0) pushes.push_back({*step.point_of(vertices[i]), shares[i] * force});
  return pushes;
}

std::vector<PointPush> shared_pushes(const ClothStep& step,
                                     const std::vector<std::size_t>& particles,
                                     const Vector3d& force) {
  double area = 0.0;
  for (const std::size_t particle : particles) area += step.area_of(particle);
  std::vector<PointPush> pushes;
  for (const std::size_t particle : particles)
    pushes.push_back({particle, (step.area_of(particle) / area) * force});
  return pushes;
}

}  // namespace

Result<std::vector<PointPush>> guest_pushes(const MixedGuests& guests, std::size_t guest,
                                            const std::string& text, const Vector3d& force) {
  const auto failed = [&](const std::string& what) {
    return content_error(key_text("at", text) + ": " + what);
  };
  std::vector<PointPush> pushes;
  if (const std::optional<VertexId> number = whole_vertex(text)) {
    const Result<std::size_t> point = guests.point_of_vertex(guest, *number);
    if (!point) return failed(point.error().message);
    pushes.push_back({*point, force});
  } else if (const TetStep* tets = guests.tets(guest)) {
    const Result<std::vector<VertexId>> found = tets_vertices(*tets, text);
    if (!found) return failed(found.error().message);
    pushes = shared_pushes(*tets, *found, force);
  } else {
    const ClothStep& cloth = *guests.cloth(guest);
    const Result<std::vector<VertexId>> found = places_or_selection(cloth, text);
    if (!found) return failed(found.error().message);
    pushes = shared_pushes(cloth, particles_of(cloth, *found), force);
  }
  const bool moves = std::any_of(pushes.begin(), pushes.end(), [&](const PointPush& push) {
    return std::isfinite(guests.mass_at(guest, push.point));
  });
  if (!moves || force.isZero(0.0))
    return failed("no vertex there moves (they are fixed), or the force is zero");
  return pushes;
}

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
    const Result<std::vector<VertexId>> found = places_or_selection(cloth, text);
    if (!found) return failed(found.error());
    points = particles_of(cloth, *found);
  }
  if (points.empty())
    return content_error(key_text(key, text) + " is no point of its surface: a weld needs some");
  return points;
}

}  // namespace tremolo
