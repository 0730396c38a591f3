#include <cstdint>
#include <limits>
#include <utility>

#include "common/text.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/vtk/vtk_input.h"

namespace tremolo {
namespace {

struct Attributes {
  bool of_cells = false;
  std::uint64_t count = 0;  // points or cells
  int rank = std::numeric_limits<int>::max();
  VtkCellArray best;
};

// `tuples` times `components` numbers of an array.
bool read_array(VtkInput& input, const std::string& name, const std::string& type,
                std::uint64_t tuples, std::uint64_t components, Attributes& found) {
  if (components != 0 && tuples > std::numeric_limits<std::uint64_t>::max() / components)
    return input.fail("expected an array that fits in the file, found " + std::to_string(tuples) +
                      " tuples");
  const std::uint64_t count = components * tuples;
  const int rank = found.of_cells && components == 1 ? region_rank(name) : -1;
  if (rank < 0 || rank >= found.rank) return input.skip_list(type, count, "values of an array");
  std::vector<double> values;
  if (!input.read_list(type, count, "numbers of an array", values)) return false;
  found.rank = rank;
  found.best = {name, std::move(values)};
  return true;
}

bool read_field(VtkInput& input, Attributes& found) {
  std::string name, type;
  std::uint64_t arrays = 0;
  if (!input.text().read_word(name, "the name of a field") ||
      !input.text().read(arrays, "the number of arrays"))
    return false;
  for (std::uint64_t a = 0; a < arrays; ++a) {
    std::uint64_t components = 0;
    std::uint64_t tuples = 0;
    if (!input.text().read_word(name, "the name of an array") ||
        !input.text().read(components, "a number of components") ||
        !input.text().read(tuples, "a number of tuples") ||
        !input.text().read_word(type, "the type of an array") ||
        !read_array(input, name, type, tuples, components, found))
      return false;
    // Each array may be followed by its own text.
    if (input.text().peek() == "METADATA") {
      input.text().token();
      skip_vtk_metadata(input);
    }
  }
  return true;
}

bool read_scalars(VtkInput& input, Attributes& found) {
  std::string name, type, table;
  std::uint64_t components = 1;
  if (!input.text().read_word(name, "the name of an array") ||
      !input.text().read_word(type, "the type of an array") ||
      (!input.text().at_line_end() && !input.text().read(components, "a number of components")))
    return false;
  if (input.text().peek() == "LOOKUP_TABLE" &&
      (!input.text().expect("LOOKUP_TABLE") ||
       !input.text().read_word(table, "the name of a lookup table")))
    return false;
  return read_array(input, name, type, found.count, components, found);
}

// Reads an array whose keyword gives the number of components.
bool read_fixed(VtkInput& input, std::uint64_t components, Attributes& found) {
  std::string name, type;
  return input.text().read_word(name, "the name of an array") &&
         input.text().read_word(type, "the type of an array") &&
         read_array(input, name, type, found.count, components, found);
}

// Colours: bytes in a binary file, numbers from 0 to 1 in a text.
bool skip_colours(VtkInput& input, std::uint64_t tuples, std::uint64_t components) {
  Attributes ignored;
  return read_array(input, "", input.binary() ? "unsigned_char" : "float", tuples, components,
                    ignored);
}

bool skip_lookup_table(VtkInput& input) {
  std::string name;
  std::uint64_t size = 0;
  return input.text().read_word(name, "the name of a lookup table") &&
         input.text().read(size, "the size of a lookup table") && skip_colours(input, size, 4);
}

bool skip_color_scalars(VtkInput& input, const Attributes& found) {
  std::string name;
  std::uint64_t components = 0;
  return input.text().read_word(name, "the name of an array") &&
         input.text().read(components, "a number of components") &&
         skip_colours(input, found.count, components);
}

bool read_texture_coordinates(VtkInput& input, Attributes& found) {
  std::string name, type;
  std::uint64_t components = 0;
  return input.text().read_word(name, "the name of an array") &&
         input.text().read(components, "a number of components") &&
         input.text().read_word(type, "the type of an array") &&
         read_array(input, name, type, found.count, components, found);
}

bool read_attribute(VtkInput& input, const std::string& keyword, Attributes& found) {
  input.begin_part(keyword);
  if (keyword == "POINT_DATA" || keyword == "CELL_DATA") {
    found.of_cells = keyword == "CELL_DATA";
    return input.text().read(found.count, "a number of points or cells");
  }
  if (keyword == "SCALARS") return read_scalars(input, found);
  if (keyword == "FIELD") return read_field(input, found);
  if (keyword == "VECTORS" || keyword == "NORMALS") return read_fixed(input, 3, found);
  if (keyword == "TENSORS") return read_fixed(input, 9, found);
  if (keyword == "GLOBAL_IDS" || keyword == "PEDIGREE_IDS") return read_fixed(input, 1, found);
  if (keyword == "TEXTURE_COORDINATES") return read_texture_coordinates(input, found);
  if (keyword == "COLOR_SCALARS") return skip_color_scalars(input, found);
  if (keyword == "LOOKUP_TABLE") return skip_lookup_table(input);
  if (keyword == "METADATA") {
    skip_vtk_metadata(input);
    return true;
  }
  return input.text().fail("data of points or cells", keyword);
}

}  // namespace

VtkCellArray read_region_array(VtkInput& input, std::string keyword, std::string& complaint) {
  Attributes found;
  while (read_attribute(input, keyword, found)) {
    if (input.text().at_end()) return std::move(found.best);
    keyword = upper_case(input.text().token());
  }
  complaint = input.error().message;
  return std::move(found.best);
}

bool skip_vtk_field(VtkInput& input) {
  Attributes ignored;
  return read_field(input, ignored);
}

void skip_vtk_metadata(VtkInput& input) {
  input.text().rest_of_line();
  while (input.text().remaining() > 0 && !input.text().rest_of_line().empty()) {
  }
}

}  // namespace tremolo
