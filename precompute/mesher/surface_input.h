// A surface file as a tetrahedral mesh, for the stage "mesh".
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/result.h"
#include "precompute/mesher/surface_mesher.h"

namespace tremolo {

// render: the surface as its author made it, m. format: "Wavefront OBJ". notes: what was found,
// what was done, what came out.
struct SurfaceInput {
  RenderSurface render;
  TetMesh mesh;
  std::string format;
  std::vector<std::string> notes;
};

// unit: as in metres_per_unit(), or empty for what the file says. Errors as of read_surface(),
// metres_per_unit() and mesh_surface(), with the path.
Result<SurfaceInput> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options);

}  // namespace tremolo
