// The kinds of cells that mesh files hold, by the numbers that the formats give them.
#pragma once

#include <cstdint>
#include <string_view>

namespace tremolo {

// nodes: how many the cell has, 0 if it varies.
struct CellKind {
  enum class Role { kTetrahedron, kHigherTetrahedron, kOther };
  std::string_view plural;
  int nodes = 0;
  Role role = Role::kOther;
};

// Element types of MSH files (Gmsh reference manual, section "MSH file format"); nullptr if
// unknown.
const CellKind* msh_cell(std::int64_t type);

// Cell types of VTK files (VTK file formats, vtkCellType.h); nullptr if unknown.
const CellKind* vtk_cell(std::int64_t type);

}  // namespace tremolo
