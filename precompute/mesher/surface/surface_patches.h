// Parts of a surface that are connected by edges, and which way they face. CGAL's
// orient_polygon_soup() orients by the first triangle of a part, not by the larger area, so that
// one turned triangle makes a cavity a superfluous shell, and cuts the surface open where a sheet
// is one-sided or three triangles meet; the numbers of both are findings. Its boundary cycles are
// those of a two-manifold.
#pragma once

#include <vector>

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/surface/surface_repair.h"

namespace tremolo {

// Triangles that are connected by edges with exactly two triangles. open: has an edge with one
// triangle. branching: meets others at an edge.
struct SurfacePatch {
  std::vector<std::size_t> triangles;
  bool open = false;
  bool branching = false;
};

// Finds the patches and turns the triangles of each to agree, with the larger area as the file has
// it. patch_of: one a triangle. Counts what it turns and the edges where none can agree.
std::vector<SurfacePatch> orient_within_patches(SurfaceMesh& surface,
                                                std::vector<std::size_t>& patch_of,
                                                SurfaceFindings& findings);

// Sets open and branching; counts closed chains of open edges and the area of the flattest caps
// over them, and edges where three triangles or more meet.
void find_holes(const SurfaceMesh& surface, const std::vector<std::size_t>& patch_of,
                std::vector<SurfacePatch>& patches, SurfaceFindings& findings);

// A patch with an edge where others end, or none, has no inside of its own: the side from which
// rays reach infinity is outside. One that sees as much in front as behind stays as it is.
void orient_open_patches(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches,
                         SurfaceFindings& findings);

// Turns all triangles of a patch, and counts them.
void turn_patch(SurfaceMesh& surface, const SurfacePatch& patch, SurfaceFindings& findings);

}  // namespace tremolo
