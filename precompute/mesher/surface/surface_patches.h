// Parts of a surface that are connected by edges, and their orientation. CGAL's
// orient_polygon_soup() orients by the first triangle of a part, not by the larger area, so that
// one reversed triangle makes a cavity a superfluous shell; it also cuts the surface open where a
// sheet is one-sided or three triangles meet; the numbers of both are findings. Its boundary cycles
// are those of a two-manifold.
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

// Finds the patches and orients the triangles of each consistently, keeping the file's orientation
// of the larger area. patch_of: one per triangle. Counts reversed triangles and the edges where no
// orientation agrees.
std::vector<SurfacePatch> orient_within_patches(SurfaceMesh& surface,
                                                std::vector<std::size_t>& patch_of,
                                                SurfaceFindings& findings);

// Sets open and branching; counts closed chains of open edges and the area of the flattest caps
// over them, and edges where three triangles or more meet.
void find_holes(const SurfaceMesh& surface, const std::vector<std::size_t>& patch_of,
                std::vector<SurfacePatch>& patches, SurfaceFindings& findings);

// A patch with a boundary, or with an edge where others end, has no inside: the side from which
// rays reach infinity is outside. One that is equally open in front and behind is unchanged.
void orient_open_patches(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches,
                         SurfaceFindings& findings);

// Turns all triangles of a patch, and counts them.
void turn_patch(SurfaceMesh& surface, const SurfacePatch& patch, SurfaceFindings& findings);

}  // namespace tremolo
