// The cells of VTK files, legacy and XML.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/mesh/mesh_builder.h"

namespace tremolo {

// Cell c is of kind types[c] (vtk_cell()) and has the nodes connectivity[offsets[c] ..
// offsets[c+1]). offsets: one more than cells, from 0. Node ids count from 0.
struct VtkCells {
  std::vector<std::int64_t> offsets;
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> types;
};

// Checks the three against each other and gives the cells to the builder, whose vertices are
// sealed. Returns a complaint that names the cell, empty if all is well.
std::string add_vtk_cells(const VtkCells& cells, MeshBuilder& builder);

}  // namespace tremolo
