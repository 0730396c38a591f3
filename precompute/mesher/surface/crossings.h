// Triangles of a surface that run through each other.
#pragma once

#include <cstddef>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Pairs of triangles that meet elsewhere than in the corners and edges they share. Exact. Every
// edge must belong to one or two triangles that agree on its direction, or the count is 1.
std::size_t count_crossings(const SurfaceMesh& surface);

}  // namespace tremolo
