// The answer of tremolo-mesh to the program that started it, tremolo-precompute.
#pragma once

#include <cstddef>
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
};

// The answer, or its error, as bytes of this machine: a line of JSON, then the vertices (n times
// three doubles) and the tetrahedra (m times four int32).
std::vector<std::byte> encode_answer(const Result<MesherAnswer>& answer);

// The inverse of encode_answer(); kSystem for bytes that it did not write.
Result<MesherAnswer> decode_answer(std::span<const std::byte> bytes);

}  // namespace tremolo
