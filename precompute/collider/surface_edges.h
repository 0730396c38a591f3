// Edges of a triangle surface: who shares them, and where the surface ends.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Turns triangles so that two that share an edge with nobody else go along it in opposite
// directions; of the triangles that hang together in that way, the larger area stays as it is.
struct Orientation {
  std::size_t turned = 0;
  bool one_sided = false;  // there is no such turning
};
Orientation orient_triangles(SurfaceMesh& surface);

// The boundary of the surface as closed loops of vertices, in the direction of the adjacent
// triangles. An edge is in k loops if k more triangles pass it in one direction than in the other.
std::vector<std::vector<VertexId>> boundary_loops(const SurfaceMesh& surface);

}  // namespace tremolo
