// What tremolo-mesh hands to the program that started it, tremolo-precompute.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// mesh: vertices (m) and tetrahedra alone. notes: what was found, what was done, what came out.
struct MesherAnswer {
  TetMesh mesh;
  std::string format;  // "Wavefront OBJ"
  std::vector<std::string> notes;
};

// The answer, or why there is none, as bytes of this machine: a line of JSON, then the vertices (n
// times three doubles) and the tetrahedra (m times four int32).
std::vector<std::byte> encode_answer(const Result<MesherAnswer>& answer);

// What encode_answer() was given; kSystem for bytes that it did not make.
Result<MesherAnswer> decode_answer(std::span<const std::byte> bytes);

}  // namespace tremolo
