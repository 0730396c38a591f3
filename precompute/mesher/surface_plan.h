// How finely a solid is to be cut.
#pragma once

#include "common/result.h"
#include "precompute/mesher/cgal/size_field.h"
#include "precompute/mesher/surface/surface_solid.h"
#include "precompute/mesher/surface_mesher.h"

namespace tremolo {

// In units of the diagonal: wanted edges between fine and coarse, wanted distance to the surface.
struct MeshPlan {
  std::vector<WallSample> walls;
  double volume = 0;
  double coarse = 0;
  double fine = 0;
  double error = 0;
  bool error_asked = false;  // by the user, who may want more tetrahedra for it
};

// Errors: kContent for walls so thin that more tetrahedra than are made unasked would be needed.
Result<MeshPlan> make_plan(const SurfaceSolid& solid, const SurfaceMeshOptions& options,
                           const Scaling& scaling);

double estimated_count(const MeshPlan& plan);

}  // namespace tremolo
