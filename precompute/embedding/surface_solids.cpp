#include <cmath>
#include <optional>

#include "common/mesh/surface_mesh.h"
#include "common/mesh/winding_number.h"
#include "precompute/embedding/surface_contacts.h"
#include "precompute/embedding/surface_sets.h"

namespace tremolo {
namespace {

// The triangles of an object, or of a material.
struct Piece {
  BoundingBox box;
  WindingNumber winding;
  double volume = 0;  // that it encloses, m^3, whichever way it faces

  explicit Piece(const SurfaceMesh& triangles) : winding(triangles) {
    std::vector<Eigen::Vector3d> used;
    for (const Triangle& t : triangles.triangles) {
      const auto x = [&](int k) -> const Eigen::Vector3d& { return triangles.vertices[t[k]]; };
      for (int k = 0; k < 3; ++k) used.push_back(x(k));
    }
    box = bounding_box(used);
    // Seen from the middle: far from the origin the sum would cancel.
    const Eigen::Vector3d middle = 0.5 * (box.low + box.high);
    for (std::size_t n = 0; n < used.size(); n += 3)
      volume += (used[n] - middle).dot((used[n + 1] - middle).cross(used[n + 2] - middle)) / 6.0;
    volume = std::abs(volume);
  }

  bool holds(const Eigen::Vector3d& x) const {
    return squared_distance(box, x) == 0.0 && std::abs(winding.at(x)) > 0.5;
  }
};

// marks: of the triangles, below `count`.
std::vector<std::optional<Piece>> make_pieces(const RenderSurface& surface,
                                              const std::vector<std::uint32_t>& marks,
                                              std::size_t count) {
  std::vector<SurfaceMesh> parts(count);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    SurfaceMesh& part = parts[marks[t]];
    const auto first = static_cast<VertexId>(part.vertices.size());
    for (const Eigen::Vector3d& x : corners_of(surface, t)) part.vertices.push_back(x);
    part.triangles.push_back({first, first + 1, first + 2});
  }
  std::vector<std::optional<Piece>> pieces(count);
  for (std::size_t mark = 0; mark < count; ++mark)
    if (!parts[mark].triangles.empty()) pieces[mark].emplace(parts[mark]);
  return pieces;
}

// The smallest piece that a point is in; none if it is in none.
std::optional<std::size_t> innermost(const std::vector<std::optional<Piece>>& pieces,
                                     const Eigen::Vector3d& x) {
  std::optional<std::size_t> found;
  for (std::size_t mark = 0; mark < pieces.size(); ++mark)
    if (pieces[mark] && (!found || pieces[mark]->volume < pieces[*found]->volume) &&
        pieces[mark]->holds(x))
      found = mark;
  return found;
}

void add_named(const RenderSurface& surface, const SurfaceContacts& contacts,
               const std::vector<std::string>& names, const std::vector<std::uint32_t>& marks,
               TetMesh& mesh) {
  const std::vector<std::optional<Piece>> pieces = make_pieces(surface, marks, names.size());
  std::vector<std::vector<std::int32_t>> inside(names.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const VertexId v : mesh.tetrahedra[t]) centre += 0.25 * mesh.vertices[v];
    const std::optional<std::size_t> found = innermost(pieces, centre);
    inside[found ? *found : marks[contacts.at(centre).triangle]].push_back(
        static_cast<std::int32_t>(t));
  }
  for (std::size_t mark = 0; mark < names.size(); ++mark)
    if (!names[mark].empty() && !inside[mark].empty() && !mesh.node_sets.contains(names[mark]))
      mesh.solids.try_emplace(names[mark], std::move(inside[mark]));
}

}  // namespace

void add_solids(const RenderSurface& surface, TetMesh& mesh) {
  if (surface.triangles.empty()) return;
  const SurfaceContacts contacts(surface);
  add_named(surface, contacts, surface.objects, surface.object_of, mesh);
  add_named(surface, contacts, surface.materials, surface.material_of, mesh);
}

}  // namespace tremolo
