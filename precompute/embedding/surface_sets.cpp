#include "precompute/embedding/surface_sets.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/surface_mesh.h"
#include "precompute/embedding/box_tree.h"
#include "precompute/embedding/closest_point.h"

namespace tremolo {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

// The point of the surface that is closest to a vertex of the mesh.
struct Contact {
  VertexId vertex = 0;
  std::size_t triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
};

Corners corners_of(const RenderSurface& surface, std::size_t triangle) {
  const Triangle& t = surface.triangles[triangle];
  return {surface.vertices[t[0]], surface.vertices[t[1]], surface.vertices[t[2]]};
}

std::vector<Contact> find_contacts(const RenderSurface& surface, const TetMesh& mesh,
                                   const std::vector<VertexId>& boundary) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Corners x = corners_of(surface, t);
    boxes.push_back({x[0].cwiseMin(x[1]).cwiseMin(x[2]), x[0].cwiseMax(x[1]).cwiseMax(x[2])});
  }
  const BoxTree tree(boxes);
  std::vector<Contact> contacts;
  contacts.reserve(boundary.size());
  for (const VertexId id : boundary) {
    const Eigen::Vector3d& x = mesh.vertices[id];
    const std::size_t triangle =
        tree.nearest(x,
                     [&](std::size_t t) {
                       return closest_on_triangle(x, corners_of(surface, t)).squared_distance;
                     })
            .item;
    contacts.push_back(
        {id, triangle, closest_on_triangle(x, corners_of(surface, triangle)).weights});
  }
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

BoxTree tree_of_points(const TetMesh& mesh, const std::vector<VertexId>& ids) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(ids.size());
  for (const VertexId id : ids) boxes.push_back({mesh.vertices[id], mesh.vertices[id]});
  return BoxTree(boxes);
}

}  // namespace

std::vector<std::string> add_surface_sets(const RenderSurface& surface, TetMesh& mesh) {
  std::vector<std::string> notes;
  if (surface.triangles.empty()) return notes;
  const std::vector<VertexId> boundary = boundary_surface(mesh).vertex_ids;
  const std::vector<Contact> contacts = find_contacts(surface, mesh, boundary);
  if (!surface.colours.empty() && mesh.colours.empty()) take_colours(surface, contacts, mesh);
  const BoxTree points = tree_of_points(mesh, boundary);
  const auto nearest = [&](const Eigen::Vector3d& x) {
    const auto squared = [&](std::size_t v) {
      return (mesh.vertices[boundary[v]] - x).squaredNorm();
    };
    return boundary[points.nearest(x, squared).item];
  };
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

}  // namespace tremolo
