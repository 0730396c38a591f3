// Shape quality of a mesh's tetrahedra.
#pragma once

#include <cstddef>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Dihedral angles in degrees: the angle between two faces, inside, at their common edge; a regular
// tetrahedron has arccos(1/3) = 70.5288 six times, a flat one is near 0 or 180. Radius ratio: three
// times the radius of the inscribed sphere over that of the circumscribed one (dimensionless), 1
// for a regular tetrahedron, 0 for a flat one. Volumes in m^3, negative where inverted.
struct MeshQuality {
  double min_dihedral_deg = 0;
  double max_dihedral_deg = 0;
  double min_radius_ratio = 0;
  double mean_radius_ratio = 0;
  double volume = 0;
  double min_volume = 0;
  std::size_t parts = 0;  // connected through shared vertices
};

// Indices must be in range. All zero for a mesh without tetrahedra. Inverted tetrahedra are judged
// like their mirror images; min_volume reveals them.
MeshQuality mesh_quality(const TetMesh& mesh);

}  // namespace tremolo
