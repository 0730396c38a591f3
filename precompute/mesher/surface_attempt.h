// One try to mesh a solid by a plan: as a polyhedron if its surface is closed, else as a field.
#pragma once

#include <string>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/surface_plan.h"

namespace tremolo {

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
