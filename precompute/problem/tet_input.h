// Reads a tetrahedral mesh file and converts it to metres, for the stage "mesh".
#pragma once

#include "formats/mesh/mesh_reader.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// The note on vertices at one place that are not joined, behind their number.
inline constexpr const char* kCoincidentNote =
    " pairs of vertices coincide: the tetrahedra around them are not joined there; --merge joins "
    "them";

// Reads request.mesh_path and multiplies its coordinates by the unit: --mesh-unit, or --unit if no
// surface is read that it would apply to; --merge joins vertices that lie at one place, which are
// counted otherwise. The notes also state the unit and warn about an
// implausible extent. Throws Failure: the errors of read_tet_mesh(), kUsage for options that apply
// to surfaces only, for an unknown unit, and for a unit given with an imported model, whose basis
// and forces are in the units of its mesh.
MeshFile load_tetrahedra(const ProblemRequest& request);

}  // namespace tremolo
