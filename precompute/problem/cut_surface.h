// A surface file as a tetrahedral mesh, for the stage "mesh": tremolo-mesh cuts it.
#pragma once

#include "common/mesh/render_surface.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// render: the surface as its author made it, m. cut: the mesh, and what was told.
struct CutSurface {
  RenderSurface render;
  MesherAnswer cut;
};

// Of request.mesh_path. The program tremolo-mesh, which stands beside this one, is a child that
// ends with this process; what it tells of its progress goes to stderr. Throws Failure: what
// read_surface(), metres_per_unit() and mesh_surface() give, with the path; kSystem if the child
// cannot be started, or ends without an answer.
CutSurface cut_surface(const ProblemRequest& request);

}  // namespace tremolo
