// Connects triangles that only touch. CGAL merges equal points. Equal triangles are merged here,
// since merge_duplicate_polygons_in_polygon_soup() changes the order of the others and with it the
// mesh, and so are gaps: stitch_borders() joins only points at the same position.
#pragma once

#include <cstddef>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

struct WeldCounts {
  std::size_t welded = 0;      // vertices at the position of another
  std::size_t degenerate = 0;  // triangles without an area
  std::size_t repeated = 0;    // triangles that were there already
  std::size_t cancelled = 0;   // triangles back to back with another one
};

// Joins vertices at one position; if edges with a single triangle remain, also vertices closer than
// 3e-5 (less where edges are short), provided that this closes some. Of triangles back to back both
// are removed if that leaves fewer open edges than keeping one of them.
WeldCounts weld(SurfaceMesh& surface);

// Removes the vertices that no triangle uses. The order of the others, and with it the mesh, stays
// as it was; CGAL's remove_isolated_points_in_polygon_soup() swaps the last ones into the gaps.
void drop_unused_vertices(SurfaceMesh& surface);

// Edges with an odd number of triangles.
std::size_t odd_edges(const SurfaceMesh& surface);

}  // namespace tremolo
