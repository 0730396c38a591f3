// The data of points and cells that may follow the mesh in a legacy VTK file.
#pragma once

#include <string>
#include <vector>

#include "formats/vtk/vtk_input.h"

namespace tremolo {

// The cell array that numbers regions (region_rank()); no name if there is none.
struct VtkCellArray {
  std::string name;
  std::vector<double> values;
};

// Reads from POINT_DATA or CELL_DATA on, which the input stands behind: `keyword`. Data that cannot
// be read end it without an error, since the mesh is complete: `complaint` then says what is wrong,
// empty otherwise.
VtkCellArray read_region_array(VtkInput& input, std::string keyword, std::string& complaint);

// The arrays of FIELD and the text of METADATA, whose keyword has been read.
bool skip_vtk_field(VtkInput& input);
void skip_vtk_metadata(VtkInput& input);

}  // namespace tremolo
