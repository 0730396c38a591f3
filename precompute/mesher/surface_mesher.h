// Any surface -> tetrahedral mesh: looks, mends, and chooses how to mesh.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh_quality.h"
#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/surface/surface_repair.h"
#include "precompute/mesher/surface_mesh_options.h"

namespace tremolo {

// Distances in metres, each the largest from 20 000 points of the one surface to the other. Points
// where a hole was closed count apart, and the way back leaves out what is not the solid's border:
// inner walls, inner shells and crumbs.
struct SurfaceMeshReport {
  SurfaceFindings findings;
  std::string method;              // "as a polyhedron with sharp edges kept"
  std::vector<std::string> notes;  // what was done, and what the user should know
  MeshQuality quality;
  std::size_t tetrahedra = 0;
  double diagonal = 0;         // of the surface's bounding box, m
  double mesh_to_surface = 0;  // of the mesh's boundary to the given surface
  double surface_to_mesh = 0;
  double cap_to_surface = 0;  // over the holes
};

struct MeshedSurface {
  TetMesh mesh;
  SurfaceMeshReport report;
};

// The same surface and options give the same mesh. Errors, each with what to do: kContent if the
// surface encloses nothing, is open beyond what can be guessed, one-sided, or too thin for the
// number of tetrahedra; kSolver if no way of meshing comes to an end.
Result<MeshedSurface> mesh_surface(const RenderSurface& surface, const SurfaceMeshOptions& options);

// The report as lines for people.
std::vector<std::string> describe(const SurfaceMeshReport& report);

}  // namespace tremolo
