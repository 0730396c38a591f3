// Raises the smallest dihedral angles of a mesh by moving vertices. CGAL's perturb_mesh_3() takes
// up to thirty times as long for the same angles.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Moves a point onto the surface; false if there is none near enough to go to.
using OntoSurface = std::function<bool(Eigen::Vector3d&)>;

// Moves the vertices of tetrahedra with a dihedral angle below `wanted` degrees, one at a time and
// only if the smallest angle of all tetrahedra around the vertex grows; vertices of the boundary
// stay on the surface, and those that `held` names (one a vertex, or none) where they are. The mesh
// must be positively oriented and stays so. The same mesh gives the same result. Returns how many
// tetrahedra are still below.
std::size_t repair_slivers(TetMesh& mesh, const OntoSurface& onto_surface,
                           const std::vector<bool>& held, double wanted);

}  // namespace tremolo
