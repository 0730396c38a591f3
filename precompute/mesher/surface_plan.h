// The element sizes for meshing a solid.
#pragma once

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

}  // namespace tremolo
