// Regions from the cell data of VTK files, legacy and XML.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "formats/vtk/vtk_cells.h"

namespace tremolo {

// How well a cell array's name says that it numbers regions: 0 is best, -1 if it does not. Known
// are material, region, gmsh:physical, medit:ref, CellEntityIds, subdomain, whatever their case,
// also with Id or Ids behind them.
int region_rank(std::string_view array);

// values: of the array `array`, one a cell. Integers become regions called "region 3"; other
// numbers are noted and left.
void set_vtk_regions(const VtkCells& cells, const std::string& array,
                     std::span<const double> values, MeshBuilder& builder);

}  // namespace tremolo
