// Triangles of a surface that run through each other, and shells that overlap: found and united by
// CGAL's exact arithmetic.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Pairs of triangles that meet elsewhere than in the corners and edges they share. Exact. Every
// edge must belong to one or two triangles that agree on its direction, or the count is 1.
std::size_t count_crossings(const SurfaceMesh& surface);

// The surface of the union of overlapping closed shells; its sharp edges are theirs. shell_of: the
// shell of each triangle, from 0. Nothing if a shell is open, intersects itself or faces inwards,
// if there are more than 200 of them, or if the result is not valid.
std::optional<SurfaceMesh> unite_shells(const SurfaceMesh& surface,
                                        const std::vector<std::size_t>& shell_of);

}  // namespace tremolo
