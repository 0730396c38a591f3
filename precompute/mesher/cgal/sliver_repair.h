// Raises the smallest dihedral angles of a mesh by moving vertices. CGAL's perturb_mesh_3() takes
// up to thirty times as long for the same angles.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Moves a point onto the surface; false if none is close enough.
using OntoSurface = std::function<bool(Eigen::Vector3d&)>;

// Moves the vertices of tetrahedra with a dihedral angle below `wanted` degrees, one at a time and
// only if the smallest angle of all tetrahedra around the vertex grows. Vertices of the boundary
// stay on the surface, and vertices flagged in `held` (one per vertex, or empty) stay in place. The
// mesh must be positively oriented and stays so. The same mesh gives the same result. Returns the
// number of tetrahedra still below.
std::size_t repair_slivers(TetMesh& mesh, const OntoSurface& onto_surface,
                           const std::vector<bool>& held, double wanted);

}  // namespace tremolo
