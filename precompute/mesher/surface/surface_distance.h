// How far two surfaces are apart.
#pragma once

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/surface/triangle_tree.h"

namespace tremolo {

// The largest distance from a point of `from` to the triangles in `to` (the one-sided Hausdorff
// distance), over all vertices and about `samples` points spread by area: a lower bound that
// misses at most the distance between neighbouring samples.
double distance_from(const SurfaceMesh& from, const TriangleTree& to, std::size_t samples);

// Points spread over a surface by area, at random but always the same.
struct SurfacePoint {
  Eigen::Vector3d point;
  std::size_t triangle = 0;
};
std::vector<SurfacePoint> spread_points(const SurfaceMesh& surface, std::size_t count);

// Twice the area of a triangle times its normal.
Eigen::Vector3d doubled_area(const SurfaceMesh& surface, const Triangle& triangle);

}  // namespace tremolo
