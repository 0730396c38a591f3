// Overlapping closed shells -> the surface of their union.
#pragma once

#include <optional>
#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// shell_of: one a triangle, from 0. By CGAL's corefinement: sharp edges stay sharp. Nothing if a
// shell is open, runs through itself, faces inwards, or if the result is not sound.
std::optional<SurfaceMesh> unite_shells(const SurfaceMesh& surface,
                                        const std::vector<std::size_t>& shell_of);

}  // namespace tremolo
