#include "common/mesh/surface_mesh.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/mesh/tet_faces.h"

namespace tremolo {

BoundarySurface boundary_surface(const TetMesh& mesh) {
  std::vector<std::size_t> outer;
  for_each_face(mesh, [&](std::span<const std::size_t> sides) {
    if (sides.size() == 1) outer.push_back(sides.front());
  });
  std::sort(outer.begin(), outer.end());

  BoundarySurface surface;
  std::vector<VertexId> position(mesh.vertices.size(), -1);
  const auto face = [&](std::size_t side) { return tet_face(mesh.tetrahedra[side / 4], side % 4); };
  for (std::size_t side : outer)
    for (VertexId id : face(side)) position[id] = 0;
  for (std::size_t id = 0; id < position.size(); ++id) {
    if (position[id] < 0) continue;
    position[id] = static_cast<VertexId>(surface.vertex_ids.size());
    surface.vertex_ids.push_back(static_cast<VertexId>(id));
  }
  for (std::size_t side : outer) {
    const auto [a, b, c] = face(side);
    surface.triangles.push_back({position[a], position[b], position[c]});
  }
  return surface;
}

SurfaceMesh boundary_mesh(const TetMesh& mesh) {
  BoundarySurface boundary = boundary_surface(mesh);
  SurfaceMesh surface;
  for (const VertexId id : boundary.vertex_ids) surface.vertices.push_back(mesh.vertices[id]);
  surface.triangles = std::move(boundary.triangles);
  return surface;
}

}  // namespace tremolo
