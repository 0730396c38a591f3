// Rigid motions: how many each part of the mesh has left, and the motions as vectors.
#pragma once

#include <array>

#include "common/mesh/tet_mesh.h"
#include "precompute/fem/matrices.h"

namespace tremolo {

// Returns for each part how many of its six infinitesimal rigid motions remain possible: 6 if
// nothing is fixed, 0 if three vertices off a line are. part_of_vertex: labels of the MeshReport;
// fixed: ascending vertex ids; held: vertices held along x, y, z.
std::vector<int> rigid_freedom(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                               int parts, const std::vector<VertexId>& fixed,
                               const std::array<std::vector<VertexId>, 3>& held = {});

// Returns six rigid modes for each part of a free body: local rows, 6 * parts columns,
// M-orthonormal.
Columns rigid_modes(const TetMesh& mesh, const std::vector<int>& part_of_vertex, int parts,
                    const LocalDofs& local, Mat mass);

}  // namespace tremolo
