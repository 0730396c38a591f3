// Divides hexahedra, wedges and pyramids into tetrahedra, so that two cells divide a common face in
// the same way.
//
// A cell is divided from its lowest corner: each triangle of the faces without that corner makes a
// tetrahedron with it. A quadrilateral face is divided from its own lowest corner (J. Dompierre et
// al., "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999), which is the same
// for the cell on its other side.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "formats/mesh/mesh_cells.h"

namespace tremolo {

// Divides a cell with kind.is_cut() into positively oriented tetrahedra, which are appended; none
// where corners coincide (a hexahedron may be written for a wedge). corners: in VTK's order. rank:
// of each vertex of the mesh; faces are divided from their corner of lowest rank. Vertices at one
// position have one rank, so that faces that are joined later are divided in the same way. Returns
// the reason if the cell is so distorted that its tetrahedra would overlap; else empty.
std::string cut_cell(const CellKind& kind, std::span<const VertexId> corners,
                     std::span<const VertexId> rank, TetMesh& mesh);

// For each vertex the lowest vertex at exactly the same position.
std::vector<VertexId> ranks_by_place(const std::vector<Eigen::Vector3d>& vertices);

}  // namespace tremolo
