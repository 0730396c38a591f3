// A surface whose large triangles have vertices inside them.
#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// The first vertices are those of the surface. Neighbouring triangles may differ in the number of
// vertices on the edge between them.
struct RefinedSurface {
  SurfaceMesh mesh;
  // For each vertex a vertex of the original surface: itself, or a corner of its triangle.
  std::vector<VertexId> origin;
};

// Divides the triangles with an edge longer than twice the spacing (m, positive) until their edges
// are no longer than the spacing. Other triangles stay as they are. Needles would need too many
// vertices: the spacing is increased so that no more than some `most` vertices are added.
RefinedSurface refine_surface(const SurfaceMesh& surface, double spacing, std::size_t most);

}  // namespace tremolo
