// A surface file as a tetrahedral mesh.
#pragma once

#include <string>

#include "common/result.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/mesher/surface_mesh_options.h"

namespace tremolo {

// unit: as for metres_per_unit(), or empty for the file's. Errors as for read_surface(),
// metres_per_unit() and mesh_surface(), with the path.
Result<MesherAnswer> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options);

}  // namespace tremolo
