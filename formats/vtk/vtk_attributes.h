// The data of points and cells that may follow the mesh in a legacy VTK file.
#pragma once

#include <string>
#include <vector>

#include "formats/vtk/vtk_input.h"

namespace tremolo {

// The cell array with region numbers (region_rank()); an empty name if there is none.
struct VtkCellArray {
  std::string name;
  std::vector<double> values;
};

// Reads from POINT_DATA or CELL_DATA on; the input is positioned after `keyword`. Unreadable data
// end it without an error, since the mesh is complete: `complaint` then gives the reason, and is
// empty otherwise.
VtkCellArray read_region_array(VtkInput& input, std::string keyword, std::string& complaint);

// Skips the arrays of FIELD and the text of METADATA, whose keyword has been read.
bool skip_vtk_field(VtkInput& input);
void skip_vtk_metadata(VtkInput& input);

}  // namespace tremolo
