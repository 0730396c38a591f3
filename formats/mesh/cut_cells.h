// Hexahedra, wedges and pyramids -> tetrahedra, without a face whose two sides are cut differently.
//
// A cell is cut from its lowest corner: each triangle of the faces that do not have it makes a
// tetrahedron with it. A quadrilateral face is cut from its own lowest corner (J. Dompierre et al.,
// "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999), which the cell on its
// other side sees as the same.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "formats/mesh/mesh_cells.h"

namespace tremolo {

// corners: of a cell that kind.is_cut(), in VTK's order. rank: of each vertex of the mesh, by which
// the lowest is found; vertices at one place have one rank, so that faces that are still to be
// joined are cut alike. Appends positively oriented tetrahedra, none where corners coincide (a
// hexahedron may be written for a wedge). Returns a complaint, empty if all is well: a cell so
// distorted that its tetrahedra would overlap.
std::string cut_cell(const CellKind& kind, std::span<const VertexId> corners,
                     std::span<const VertexId> rank, TetMesh& mesh);

// Of each vertex the lowest that lies at exactly the same place.
std::vector<VertexId> ranks_by_place(const std::vector<Eigen::Vector3d>& vertices);

}  // namespace tremolo
