// The result of meshing a surface: its parts, and the distances between mesh and surface.
#pragma once

#include "common/mesh/tet_mesh.h"
#include "precompute/mesher/surface/surface_solid.h"

namespace tremolo {

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
