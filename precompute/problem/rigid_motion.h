// Rigid motions: which parts of the mesh can still move rigidly, and those motions as vectors.
#pragma once

#include <array>

#include "common/mesh/tet_mesh.h"
#include "precompute/fem/matrices.h"

namespace tremolo {

// How many of a part's six infinitesimal rigid motions vanish nowhere on its fixed vertices, i.e.
// stay possible: 6 when nothing is fixed, 0 when three vertices off a line are.
// part_of_vertex: MeshReport's labels; fixed: ascending vertex ids; held: those that do not move
// along x, y, z.
std::vector<int> rigid_freedom(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                               int parts, const std::vector<VertexId>& fixed,
                               const std::array<std::vector<VertexId>, 3>& held = {});

// Six motions for each part of a body that nothing holds: local rows, 6*parts columns,
// orthonormal in the mass matrix.
Columns rigid_modes(const TetMesh& mesh, const std::vector<int>& part_of_vertex, int parts,
                    const LocalDofs& local, Mat mass);

}  // namespace tremolo
