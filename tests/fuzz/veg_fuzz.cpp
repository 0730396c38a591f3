// VegaFEM's .veg; *INCLUDE finds b.node and b.ele in tests/fuzz/included.
#include "formats/mesh/mesh_reader.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  check_mesh_file(read_veg(bytes, TREMOLO_SOURCE_DIR "/tests/fuzz/included/input.veg"));
}
