// Reads the file of a solid: a surface, which the program tremolo-mesh turns into tetrahedra, or
// tetrahedra.
#pragma once

#include "common/mesh/render_surface.h"
#include "formats/mesh/mesh_reader.h"
#include "precompute/mesher/mesher_answer.h"
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
