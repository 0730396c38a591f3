#include "precompute/embedding/surface_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "common/mesh/surface_mesh.h"
#include "precompute/embedding/box_tree.h"
#include "precompute/embedding/surface_contacts.h"

namespace tremolo {
namespace {

// The point of the surface that is closest to a vertex of the mesh.
struct Contact : SurfaceContact {
  VertexId vertex = 0;
};

std::vector<Contact> find_contacts(const RenderSurface& surface, const TetMesh& mesh,
                                   const std::vector<VertexId>& boundary) {
  const SurfaceContacts closest(surface);
  std::vector<Contact> contacts;
  contacts.reserve(boundary.size());
  for (const VertexId id : boundary) contacts.push_back({closest.at(mesh.vertices[id]), id});
  return contacts;
}

void take_colours(const RenderSurface& surface, const std::vector<Contact>& contacts,
                  TetMesh& mesh) {
  mesh.colours.assign(mesh.vertices.size(), Colour{});
  for (const Contact& contact : contacts)
    for (std::size_t channel = 0; channel < 4; ++channel) {
      double value = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        value +=
            contact.weights[k] * surface.colours[surface.triangles[contact.triangle][k]][channel];
      mesh.colours[contact.vertex][channel] = static_cast<std::uint8_t>(std::lround(value));
    }
}

// Finds the vertex of the boundary that is nearest to a place.
class NearestVertex {
 public:
  NearestVertex(const TetMesh& mesh, const std::vector<VertexId>& boundary)
      : mesh_(mesh), boundary_(boundary), tree_(tree_of_points(mesh, boundary)) {}

  VertexId operator()(const Eigen::Vector3d& x) const {
    const auto squared = [&](std::size_t v) {
      return (mesh_.vertices[boundary_[v]] - x).squaredNorm();
    };
    return boundary_[tree_.nearest(x, squared).item];
  }

 private:
  static BoxTree tree_of_points(const TetMesh& mesh, const std::vector<VertexId>& ids) {
    std::vector<BoundingBox> boxes;
    boxes.reserve(ids.size());
    for (const VertexId id : ids) boxes.push_back({mesh.vertices[id], mesh.vertices[id]});
    return BoxTree(boxes);
  }

  const TetMesh& mesh_;
  const std::vector<VertexId>& boundary_;
  BoxTree tree_;
};

// Corners with less weight do not carry the point: it is on an edge or at a corner.
constexpr double kOnEdge = 1e-4;

std::vector<VertexId> first_at_each_position(const RenderSurface& surface) {
  std::map<std::array<double, 3>, VertexId> first;
  std::vector<VertexId> first_at;
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    const Eigen::Vector3d& x = surface.vertices[v];
    first_at.push_back(
        first.try_emplace({x[0], x[1], x[2]}, static_cast<VertexId>(v)).first->second);
  }
  return first_at;
}

}  // namespace

std::vector<std::string> add_surface_sets(const RenderSurface& surface, TetMesh& mesh) {
  std::vector<std::string> notes;
  if (surface.triangles.empty()) return notes;
  const std::vector<VertexId> boundary = boundary_surface(mesh).vertex_ids;
  const std::vector<Contact> contacts = find_contacts(surface, mesh, boundary);
  if (!surface.colours.empty() && mesh.colours.empty()) take_colours(surface, contacts, mesh);
  const NearestVertex nearest(mesh, boundary);
  const auto add = [&](const std::vector<std::string>& names,
                       const std::vector<std::uint32_t>& marks, const char* kind) {
    std::vector<std::vector<VertexId>> sets(names.size());
    std::vector<bool> met(names.size(), false);
    for (const Contact& contact : contacts) {
      sets[marks[contact.triangle]].push_back(contact.vertex);
      met[marks[contact.triangle]] = true;
    }
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      if (!met[marks[t]])
        for (const Eigen::Vector3d& x : corners_of(surface, t))
          sets[marks[t]].push_back(nearest(x));
    for (std::size_t mark = 0; mark < names.size(); ++mark) {
      if (names[mark].empty()) continue;
      if (mesh.node_sets.contains(names[mark])) {
        notes.push_back(std::string("the ") + kind + " `" + names[mark] +
                        "` of the render surface makes no set: a set of that name exists already");
        continue;
      }
      std::vector<VertexId>& ids = sets[mark];
      std::sort(ids.begin(), ids.end());
      ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
      if (!ids.empty()) mesh.node_sets.emplace(names[mark], std::move(ids));
    }
  };
  add(surface.objects, surface.object_of, "object");
  add(surface.materials, surface.material_of, "material");
  return notes;
}

void add_given_vertices(const RenderSurface& surface, TetMesh& mesh) {
  auto given = std::make_shared<GivenVertices>();
  given->count = surface.authored();
  given->first_at = first_at_each_position(surface);
  given->boundary = boundary_surface(mesh).vertex_ids;
  const NearestVertex nearest(mesh, given->boundary);
  for (const Eigen::Vector3d& x : surface.vertices) given->nearest.push_back(nearest(x));
  for (const Triangle& t : surface.triangles)
    given->corners.push_back({given->first_at[t[0]], given->first_at[t[1]], given->first_at[t[2]]});
  for (const Contact& contact : find_contacts(surface, mesh, given->boundary)) {
    Triangle below = given->corners[contact.triangle];
    for (int k = 0; k < 3; ++k)
      if (contact.weights[k] < kOnEdge) below[k] = -1;
    given->below.push_back(below);
  }
  mesh.given = std::move(given);
}

}  // namespace tremolo
