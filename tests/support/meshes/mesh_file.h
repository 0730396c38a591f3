// A mesh as a small text file that the programs can read (VegaFEM's .veg).
#pragma once

#include <fstream>
#include <iomanip>
#include <string>

#include "common/mesh/tet_mesh.h"

namespace tremolo::testing {

inline void write_veg(const std::string& path, const TetMesh& mesh) {
  std::ofstream file(path);
  file << std::setprecision(17) << "*VERTICES\n" << mesh.vertices.size() << " 3 0 0\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    file << v + 1 << ' ' << mesh.vertices[v].transpose() << '\n';
  file << "*ELEMENTS\nTETS\n" << mesh.tetrahedra.size() << " 4 0\n";
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    file << e + 1;
    for (VertexId v : mesh.tetrahedra[e]) file << ' ' << v + 1;
    file << '\n';
  }
}

}  // namespace tremolo::testing
