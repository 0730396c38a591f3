// Which vertices of a render surface are one vertex to the eye.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/render_surface.h"

namespace tremolo {

// group_of: s, below count. Every group has a vertex.
struct SmoothPatches {
  std::vector<std::uint32_t> group_of;
  std::size_t count = 0;
};

// Vertices are split where texture coordinates, materials or normals are. Vertices at exactly the
// same position whose rest normals agree to a thousandth belong to one patch: the author shades
// across them. Without rest normals, vertices at the same position whose first triangles are of one
// object do.
SmoothPatches find_smooth_patches(const RenderSurface& surface);

}  // namespace tremolo
