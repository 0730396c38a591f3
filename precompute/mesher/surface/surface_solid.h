// The solid that a surface represents. Lengths are in units of the bounding box's diagonal.
#pragma once

#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"
#include "common/mesh/winding_number.h"
#include "precompute/mesher/surface/surface_geometry.h"
#include "precompute/mesher/surface/surface_repair.h"

namespace tremolo {

// Between the file's metres and a diagonal of 1 about the origin.
struct Scaling {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double diagonal = 1;  // m
  Eigen::Vector3d in(const Eigen::Vector3d& x) const { return (x - centre) / diagonal; }
  Eigen::Vector3d out(const Eigen::Vector3d& x) const { return diagonal * x + centre; }
};

// The surface scaled; unused vertices are ignored. No triangles if all vertices are at one
// position.
SurfaceMesh scale(const RenderSurface& given, Scaling& scaling);

// shell_of: one per triangle. half_thickness: above 0 for a sheet. closed: the surface encloses the
// solid without holes or crossings.
struct SurfaceSolid {
  SurfaceMesh surface;
  std::vector<std::size_t> shell_of;
  TriangleTree tree;
  WindingNumber winding;
  double half_thickness = 0;
  bool closed = false;

  SurfaceSolid(RepairedSurface repaired, double thickness);
  bool inside(const Eigen::Vector3d& x) const;
};

// backed: fraction of the surface behind which the solid is. lacking: the missing fraction of the
// full solid angle there, on average; a sheet has one half, half a sphere 0.18.
struct Openness {
  double backed = 0;
  double lacking = 0;
};
Openness openness(const SurfaceSolid& solid);

// Exact for a closed surface, else from 40 000 points: to about 1 % for a compact solid.
double volume(const SurfaceSolid& solid);
// The standard deviation of volume(solid), as a share of it; 0 where that is exact. volume: above
// 0.
double volume_deviation(const SurfaceSolid& solid, double volume);

// A mesh farther from its surface than this, in units of the diagonal, does not follow it.
inline constexpr double kWorstError = 0.01;

struct PartCounts {
  std::size_t kept = 0, dropped = 0;
};

// Removes parts of less than 1 % of the largest one's volume, unless they are to be kept.
PartCounts drop_crumbs(TetMesh& mesh, bool keep);

// In units of the diagonal; see SurfaceMeshReport. error: the requested distance.
struct SurfaceDistances {
  double mesh_to_surface = 0;
  double surface_to_mesh = 0;
  double cap_to_surface = 0;
};
SurfaceDistances measure_distances(const SurfaceSolid& solid, double error, const TetMesh& mesh);

}  // namespace tremolo
