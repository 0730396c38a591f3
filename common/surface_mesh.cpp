#include "common/surface_mesh.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tremolo {
namespace {

// Faces of a positively oriented tetrahedron, counter-clockwise from outside.
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Face {
  Triangle key;  // sorted ids: equal for the two sides of an inner face
  std::size_t index;
};

}  // namespace

BoundarySurface boundary_surface(const TetMesh& mesh) {
  std::vector<Triangle> oriented;
  std::vector<Face> faces;
  oriented.reserve(4 * mesh.tetrahedra.size());
  faces.reserve(4 * mesh.tetrahedra.size());
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    for (const auto& local : kFaces) {
      const Triangle face{tet[local[0]], tet[local[1]], tet[local[2]]};
      Triangle key = face;
      std::sort(key.begin(), key.end());
      faces.push_back({key, oriented.size()});
      oriented.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });

  std::vector<std::size_t> outer;
  for (std::size_t first = 0; first < faces.size();) {
    std::size_t last = first + 1;
    while (last < faces.size() && faces[last].key == faces[first].key) ++last;
    if (last - first == 1) outer.push_back(faces[first].index);
    first = last;
  }
  std::sort(outer.begin(), outer.end());

  BoundarySurface surface;
  std::vector<VertexId> position(mesh.vertices.size(), -1);
  for (std::size_t index : outer)
    for (VertexId id : oriented[index]) position[id] = 0;
  for (std::size_t id = 0; id < position.size(); ++id) {
    if (position[id] < 0) continue;
    position[id] = static_cast<VertexId>(surface.vertex_ids.size());
    surface.vertex_ids.push_back(static_cast<VertexId>(id));
  }
  for (std::size_t index : outer) {
    const Triangle& face = oriented[index];
    surface.triangles.push_back({position[face[0]], position[face[1]], position[face[2]]});
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
