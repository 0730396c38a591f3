// Edges of a triangle surface: their triangles, and the boundary of the surface.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Reverses triangles so that two that are the only ones at an edge pass it in opposite directions;
// in each connected set, the orientation of the larger area is kept.
struct Orientation {
  std::size_t turned = 0;
  bool one_sided = false;  // there is no such orientation
};
Orientation orient_triangles(SurfaceMesh& surface);

// The boundary of the surface as closed loops of vertices, in the direction of the adjacent
// triangles. An edge is in k loops if k more triangles pass it in one direction than in the other.
std::vector<std::vector<VertexId>> boundary_loops(const SurfaceMesh& surface);

}  // namespace tremolo
