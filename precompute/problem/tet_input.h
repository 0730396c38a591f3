// Reads a tetrahedral mesh file and converts it to metres, for the stage "mesh".
#pragma once

#include "formats/mesh/mesh_reader.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// The note on vertices at one place that are not joined, behind their number.
inline constexpr const char* kCoincidentNote =
    " pairs of vertices coincide: the tetrahedra around them are not joined there; --merge joins "
    "them";

// Reads files.mesh and multiplies its coordinates by the unit: --mesh-unit, or --unit if no surface
// is read that it would apply to. --merge joins vertices that lie at one place, which are counted
// otherwise. The notes also state the unit and warn about an implausible extent. imported: the mesh
// of an imported model, whose basis and forces are in its units. Throws Failure: the errors of
// read_tet_mesh(); kUsage for options that apply to surfaces only, and for a unit or --merge of an
// imported model.
MeshFile load_tetrahedra(const SolidFiles& files, bool imported);

}  // namespace tremolo
