// The messages between tremolo-precompute and tremolo-mesh, which it starts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A mesh with its notes.
struct MesherAnswer {
  TetMesh mesh;                    // only vertices (m) and tetrahedra
  std::string format;              // "Wavefront OBJ"
  std::vector<std::string> notes;  // findings, repairs and results
  // Triangles of the surface that were turned to face outwards, ascending.
  std::vector<std::int32_t> turned;
};

// The answer, or its error, as bytes of this machine: a line of JSON, then the vertices (n times
// three doubles), the tetrahedra (m times four int32) and the turned triangles (k int32).
std::vector<std::byte> encode_answer(const Result<MesherAnswer>& answer);

// The inverse of encode_answer(); kSystem for bytes that it did not write.
Result<MesherAnswer> decode_answer(std::span<const std::byte> bytes);

// Options for meshing a surface.
struct SurfaceMeshOptions {
  double size = 0;           // requested edge, m (some are longer); 0: by the count
  int tets = 0;              // requested number of tetrahedra; 0: 10 000, or more for thin walls
  double error = 0;          // requested distance between the surfaces, m; 0: 0.3 % of the diagonal
  double thicken = 0;        // m; above 0 the surface is a sheet of that thickness
  bool fill_holes = false;   // close holes of any size
  bool keep_crumbs = false;  // keep parts far smaller than the largest
};

}  // namespace tremolo
