// The kinds of cells in mesh files, by the numbers of the formats.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// nodes: how many the cell has, 0 if it varies. A quadratic tetrahedron has its corners first, then
// the middles of its edges 01, 12, 02, 03 and 13, 23, of which Gmsh has the last two exchanged.
struct CellKind {
  enum class Role {
    kTetrahedron,
    kQuadraticTetrahedron,
    kGmshQuadraticTetrahedron,
    kHigherTetrahedron,
    kHexahedron,
    kVoxel,  // a hexahedron with its corners in the order of a grid, x first
    kWedge,
    kPyramid,
    kOther
  };
  std::string_view plural;
  int nodes = 0;
  Role role = Role::kOther;

  bool is_quadratic() const {
    return role == Role::kQuadraticTetrahedron || role == Role::kGmshQuadraticTetrahedron;
  }
  // True if the cell is divided into tetrahedra by its corners; further nodes follow the corners.
  bool is_cut() const { return corners() > 0; }
  int corners() const {
    if (role == Role::kHexahedron || role == Role::kVoxel) return 8;
    return role == Role::kWedge ? 6 : role == Role::kPyramid ? 5 : 0;
  }
  // True if cells of this kind become tetrahedra of the mesh.
  bool is_kept() const { return role == Role::kTetrahedron || is_quadratic() || is_cut(); }
};

// Above 2^53 not every integer is a double: larger numbers are not valid regions.
inline constexpr double kMostExact = 9007199254740992.0;

// Element types of MSH files (Gmsh reference manual, section "MSH file format"); nullptr if
// unknown.
const CellKind* msh_cell(std::int64_t type);

// Cell types of VTK files (VTK file formats, vtkCellType.h); nullptr if unknown.
const CellKind* vtk_cell(std::int64_t type);

// Divides hexahedra, wedges and pyramids into tetrahedra, so that two cells divide a common face in
// the same way.
//
// A cell is divided from its lowest corner: each triangle of the faces without that corner makes a
// tetrahedron with it. A quadrilateral face is divided from its own lowest corner (J. Dompierre et
// al., "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999), which is the same
// for the cell on its other side.

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
