// Checks the values of a file of tetrahedra (formats/tets/tets_file.h).
#pragma once

#include <string>

#include "formats/tets/tets_file.h"

namespace tremolo {

// An error in the file, and the section that has it.
struct TetsFault {
  std::string_view section;
  std::string problem;
};

// Everything but the grid, which DistanceGrid::create() checks. Nothing: all is well.
std::optional<TetsFault> find_tets_fault(const TetMesh& mesh, const MaterialTable& materials,
                                         std::span<const VertexId> held,
                                         const TetsSurface& surface);

}  // namespace tremolo
