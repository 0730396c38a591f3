// The last steps of every conversion of a file to a RenderSurface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"

namespace tremolo {

// Bytes of a vertex and of a triangle in a RenderSurface.
inline constexpr std::uint64_t kVertexBytes = 48;
inline constexpr std::uint64_t kTriangleBytes = 20;

// Numbers of things that do not become triangles.
struct LeftOut {
  std::uint64_t points = 0;
  std::uint64_t lines = 0;
  std::uint64_t polygons = 0;    // that cannot be cut
  std::uint64_t not_finite = 0;  // triangles with coordinates that are no numbers
};

void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes);

// Vertices whose flag is false get the normal of their triangles, weighted by area; if all flags
// are false, the surface keeps no normals.
void fill_missing_normals(RenderSurface& surface, const std::vector<bool>& has_normal);

}  // namespace tremolo
