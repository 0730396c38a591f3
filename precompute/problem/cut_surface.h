// Reads a surface file and has the program tremolo-mesh turn it into a tetrahedral mesh.
#pragma once

#include "common/mesh/render_surface.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// render: the surface as read, m. cut: the tetrahedral mesh and the mesher's notes.
struct CutSurface {
  RenderSurface render;
  MesherAnswer cut;
};

// Meshes files.mesh. The program tremolo-mesh, which must lie beside this one, runs as a
// child that ends with this process; its progress messages go to stderr. Throws Failure: the errors
// of read_surface() and mesh_surface(), with the path; kSystem if the child
// cannot be started or ends without an answer.
CutSurface cut_surface(const SolidFiles& files);

}  // namespace tremolo
