// A tetrahedral mesh file in metres, for the stage "mesh".
#pragma once

#include "formats/mesh/mesh_reader.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Of request.mesh_path, whose coordinates are multiplied by the unit that was given: --mesh-unit,
// or --unit where no other surface is read that it would be of. notes: also the unit, and an extent
// that makes one doubt it. Throws Failure: as read_tet_mesh(), kUsage for options that are of
// meshing a surface only, for what is no unit, and for a unit of an imported model, whose basis and
// forces are in the units of its mesh.
MeshFile load_tetrahedra(const ProblemRequest& request);

}  // namespace tremolo
