// TetMesh -> Gmsh's MSH 2.2, binary.
#pragma once

#include <string>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// Writes one block of tetrahedra without tags; node sets are left out (MSH 2.2 has none). Written
// whole or not at all. Errors: kSystem if the file cannot be written.
Status write_msh(const std::string& path, const TetMesh& mesh);

}  // namespace tremolo
