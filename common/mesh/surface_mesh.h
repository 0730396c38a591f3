// Triangle surfaces, and the boundary of a tetrahedral mesh.
#pragma once

#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// vertices: positions in metres. triangles: indices into vertices, counter-clockwise from outside.
struct SurfaceMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
};

// The boundary of a mesh in terms of the mesh's own vertices.
// vertex_ids: ascending ids of the vertices on the boundary. triangles: indices into vertex_ids.
struct BoundarySurface {
  std::vector<VertexId> vertex_ids;
  std::vector<Triangle> triangles;
};

// Faces that belong to exactly one tetrahedron, oriented outwards (the mesh must be positively
// oriented). Order: by tetrahedron, then by local face; the same mesh gives the same surface.
BoundarySurface boundary_surface(const TetMesh& mesh);

// The same with vertices of its own.
SurfaceMesh boundary_mesh(const TetMesh& mesh);

}  // namespace tremolo
