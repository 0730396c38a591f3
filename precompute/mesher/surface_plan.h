// The element sizes for meshing a solid.
#pragma once

#include <string>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/cgal/size_field.h"
#include "precompute/mesher/surface/surface_solid.h"
#include "precompute/mesher/surface_mesher.h"

namespace tremolo {

// Lengths in units of the diagonal.
struct MeshPlan {
  std::vector<WallSample> walls;
  double volume = 0;
  double coarse = 0;         // the longest edge requested
  double fine = 0;           // the shortest edge requested
  double error = 0;          // requested distance to the surface
  bool error_asked = false;  // requested by the user, even if it takes more tetrahedra
};

// Errors: kContent for walls so thin that more tetrahedra than are made unasked would be needed.
Result<MeshPlan> make_plan(const SurfaceSolid& solid, const SurfaceMeshOptions& options,
                           const Scaling& scaling);

double estimated_count(const MeshPlan& plan);

// Half of the walls are thinner; 0 without walls.
double median_thickness(const MeshPlan& plan);

// True if so much of the walls is far thinner than the finest size that a smaller one would lead to
// hundreds of thousands of tetrahedra.
bool has_thin_walls(const MeshPlan& plan);

// A smallest dihedral angle below it, in degrees, is worth another attempt and a note.
inline constexpr double kGoodAngle = 8.0;

// method: "as a polyhedron, its sharp edges kept".
struct MeshAttempt {
  TetMesh mesh;
  std::string method;
};

// The mesh may be empty. Errors: kSolver if the mesher does not end.
Result<MeshAttempt> attempt_mesh(const SurfaceSolid& solid, const MeshPlan& plan);

// True if such a fraction of the requested number of tetrahedra counts as that number: within 10 %.
bool is_met(double share);

// Scales the plan's sizes until `wanted` tetrahedra are met, in at most six tries, of which the
// nearest is used; 0: one try.
Result<MeshAttempt> attempt_mesh_to_count(const SurfaceSolid& solid, MeshPlan plan, int wanted);

}  // namespace tremolo
