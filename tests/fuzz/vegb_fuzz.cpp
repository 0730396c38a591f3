// VegaFEM's .vegb.
#include "formats/mesh/mesh_reader.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  check_mesh_file(read_vegb(bytes, "input.vegb"));
}
