// TetGen's .node and .ele: the part before the first $ is the one, the part behind it the
// other.
#include "formats/mesh/mesh_reader.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const std::size_t cut = bytes.find('$');
  if (cut == std::string_view::npos) return;
  check_mesh_file(
      read_tetgen_texts(bytes.substr(0, cut), "input.node", bytes.substr(cut + 1), "input.ele"));
}
