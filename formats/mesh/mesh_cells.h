// The kinds of cells in mesh files, by the numbers of the formats.
#pragma once

#include <cstdint>
#include <string_view>

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
  // True if the cell is divided into tetrahedra (cut_cells.h) by its corners; further nodes follow
  // the corners.
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

}  // namespace tremolo
