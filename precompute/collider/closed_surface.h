// The surface that encloses a solid, made of an author's surface: vertices at one position are
// joined, triangles oriented consistently, holes closed, parts oriented outwards, and parts inside
// others identified.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

// A hole that is larger, in parts of the surface's diagonal, is not closed by itself: a cup has an
// opening, not a hole.
inline constexpr double kLargestHole = 0.1;

// A closed surface, oriented outwards; points inside have a winding number above one half.
struct ClosedSurface {
  SurfaceMesh surface;
  // One per triangle: 1 if both its sides are inside, so that it is not part of the solid's
  // boundary.
  std::vector<char> buried;
  std::size_t parts = 0;             // shells
  std::size_t turned_triangles = 0;  // against their neighbours
  std::size_t turned_parts = 0;      // they faced inwards
  std::size_t holes = 0;             // that were closed
  double largest_hole = 0;           // m, the diagonal of its box
  std::size_t buried_triangles = 0;
  std::vector<std::string> notes;  // repairs, for the user
};

// any_hole: close holes of every size. Errors (kContent): no triangle with an area; a surface with
// one side; a hole that is too large; a surface that encloses no volume.
Result<ClosedSurface> close_surface(const RenderSurface& given, bool any_hole,
                                    unsigned threads = 1);

}  // namespace tremolo
