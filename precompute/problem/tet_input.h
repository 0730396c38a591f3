// Reads a tetrahedral mesh file and converts it to metres, for the stage "mesh".
#pragma once

#include "formats/mesh/mesh_reader.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Reads request.mesh_path and multiplies its coordinates by the unit: --mesh-unit, or --unit if no
// surface is read that it would apply to. The notes also state the unit and warn about an
// implausible extent. Throws Failure: the errors of read_tet_mesh(), kUsage for options that apply
// to surfaces only, for an unknown unit, and for a unit given with an imported model, whose basis
// and forces are in the units of its mesh.
MeshFile load_tetrahedra(const ProblemRequest& request);

}  // namespace tremolo
