// The cells of VTK files, legacy and XML, and the regions that their data number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/mesh/mesh_builder.h"

namespace tremolo {

// Cell c is of kind types[c] (vtk_cell()) and has the nodes connectivity[offsets[c] ..
// offsets[c+1]). offsets: one more than cells, from 0. Node ids count from 0.
struct VtkCells {
  std::vector<std::int64_t> offsets;
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> types;
  std::vector<std::uint8_t> tetrahedra;  // that each cell became; set by add_vtk_cells()
};

// Appends the cells of one piece to those of the earlier ones. id_of_point: the number that each
// point of the piece has in the mesh. Returns a complaint as add_vtk_cells() does.
std::string append_vtk_cells(const VtkCells& piece, std::span<const std::int64_t> id_of_point,
                             VtkCells& cells);

// Checks the three lists against each other and adds the cells to the builder, whose vertices are
// sealed. Returns a complaint with the cell, or an empty text.
std::string add_vtk_cells(VtkCells& cells, MeshBuilder& builder);

// Rates the name of a cell array as region numbers: 0 is best, -1 if it is no such name. Known are
// material, region, gmsh:physical, medit:ref, CellEntityIds, subdomain, in any case, also followed
// by Id or Ids.
int region_rank(std::string_view array);

// values: of the array `array`, one per cell. Integers become regions called "region 3"; other
// numbers are noted and ignored.
void set_vtk_regions(const VtkCells& cells, const std::string& array,
                     std::span<const double> values, MeshBuilder& builder);

}  // namespace tremolo
