// Meshes any surface with tetrahedra: checks, repairs, and chooses the method.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh_quality.h"
#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/mesher/surface/surface_repair.h"

namespace tremolo {

// Distances in metres, each the largest from 20 000 points of one surface to the other. Points at
// closed holes are counted separately, and the distance from the surface to the mesh ignores parts
// that are not the solid's border: inner walls, inner shells and crumbs.
struct SurfaceMeshReport {
  SurfaceFindings findings;
  std::string method;              // "as a polyhedron with sharp edges kept"
  std::vector<std::string> notes;  // steps taken, and warnings for the user
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
  std::vector<std::int32_t> turned;  // triangles of the surface that were turned, ascending
};

// The same surface and options give the same mesh. Errors, each with what to do: kContent if the
// surface encloses nothing, has too large openings, is one-sided, or too thin for the number of
// tetrahedra; kSolver if no method of meshing succeeds.
Result<MeshedSurface> mesh_surface(const RenderSurface& surface, const SurfaceMeshOptions& options);

// Rounds all coordinates to single precision in the file's unit if none moves by more than 2^-27 of
// the largest: the numbers are then floats that a program printed in decimals, and its planes and
// straight edges come back exactly. Otherwise nothing changes. metres_per_unit: above 0.
void restore_printed_floats(std::vector<Eigen::Vector3d>& vertices, double metres_per_unit);

// The report as lines for people.
std::vector<std::string> describe(const SurfaceMeshReport& report);

// A surface file as a tetrahedral mesh. unit: as for metres_per_unit(), or empty for the file's.
// Errors as for read_surface(), metres_per_unit() and mesh_surface(), with the path.
Result<MesherAnswer> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options);

}  // namespace tremolo
