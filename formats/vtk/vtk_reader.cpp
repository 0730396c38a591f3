#include <cstddef>

#include "common/packed_index.h"
#include "common/text.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/vtk/vtk_input.h"

namespace tremolo {
namespace {

struct VtkFile {
  MeshBuilder builder;
  VtkCells cells;
  std::string cells_part;  // their position
  bool has_points = false;
  bool has_cells = false;
  bool has_types = false;
};

bool read_points(VtkInput& input, VtkFile& file) {
  std::uint64_t count = 0;
  std::string type;
  std::vector<double> coordinates;
  if (file.has_points) return input.fail("expected one list POINTS, found a second");
  if (!input.text().read(count, "the number of points") || !input.text().fits(count, 3, "points") ||
      !input.text().read_word(type, "the type of the coordinates") ||
      !input.read_list(type, 3 * count, "coordinates", coordinates))
    return false;
  file.builder.reserve_vertices(count);
  for (std::uint64_t p = 0; p < count; ++p)
    if (!file.builder.add_vertex(p, Eigen::Vector3d(coordinates.data() + 3 * p)))
      return input.fail(file.builder.complaint());
  file.has_points = true;
  return file.builder.seal_vertices() || input.fail(file.builder.complaint());
}

// Since version 5.1: a list of offsets and one of nodes.
bool read_offset_cells(VtkInput& input, std::uint64_t offsets, std::uint64_t nodes,
                       VtkCells& cells) {
  std::string type;
  return input.text().expect("OFFSETS") && input.text().read_word(type, "the type of offsets") &&
         input.read_list(type, offsets, "cell offsets", cells.offsets) &&
         input.text().expect("CONNECTIVITY") && input.text().read_word(type, "the type of nodes") &&
         input.read_list(type, nodes, "nodes of cells", cells.connectivity);
}

// The older form: one list in which each cell's number of nodes precedes its nodes.
bool read_counted_cells(VtkInput& input, std::uint64_t count, std::uint64_t size, VtkCells& cells) {
  std::vector<std::int64_t> list;
  if (!input.read_list("int", size, "nodes of cells", list)) return false;
  if (count > list.size())
    return input.fail("expected " + std::to_string(count) + " cells, found a list of " +
                      std::to_string(list.size()) + " numbers");
  cells.offsets.assign(1, 0);
  std::size_t at = 0;
  for (std::uint64_t c = 0; c < count; ++c) {
    const std::size_t left = list.size() - at;
    if (left == 0 || !is_index(list[at], left))
      return input.fail("cell " + std::to_string(c) + " has " +
                        (left == 0 ? "no" : std::to_string(list[at])) +
                        " nodes, expected at most the " + std::to_string(left) +
                        " numbers that are left in the list");
    const std::size_t nodes = list[at];
    cells.connectivity.insert(cells.connectivity.end(), list.begin() + at + 1,
                              list.begin() + at + 1 + nodes);
    cells.offsets.push_back(cells.connectivity.size());
    at += nodes + 1;
  }
  return at == list.size() ||
         input.fail("expected a list of " + std::to_string(at) + " numbers for " +
                    std::to_string(count) + " cells, found " + std::to_string(list.size()));
}

bool read_cells(VtkInput& input, VtkFile& file) {
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  if (file.has_cells) return input.fail("expected one list CELLS, found a second");
  file.has_cells = true;
  file.cells_part = input.part();
  if (!input.text().read(first, "the number of cells") ||
      !input.text().read(second, "the length of the list of cells"))
    return false;
  // In a binary file the bytes of the older list begin on the next line and are no keyword.
  const std::string_view rest = input.text().text().substr(input.text().offset());
  const std::size_t word = rest.find_first_not_of(" \t\r\n");
  const bool offsets = word != std::string_view::npos && rest.substr(word).starts_with("OFFSETS");
  return offsets ? read_offset_cells(input, first, second, file.cells)
                 : read_counted_cells(input, first, second, file.cells);
}

bool read_types(VtkInput& input, VtkFile& file) {
  std::uint64_t count = 0;
  if (file.has_types) return input.fail("expected one list CELL_TYPES, found a second");
  file.has_types = true;
  return input.text().read(count, "the number of cell types") &&
         input.read_list("int", count, "cell types", file.cells.types);
}

bool read_part(VtkInput& input, const std::string& keyword, VtkFile& file) {
  input.begin_part(keyword);
  if (keyword == "POINTS") return read_points(input, file);
  if (keyword == "CELLS") return read_cells(input, file);
  if (keyword == "CELL_TYPES") return read_types(input, file);
  if (keyword == "FIELD") return skip_vtk_field(input);
  if (keyword == "METADATA") {
    skip_vtk_metadata(input);
    return true;
  }
  return input.text().fail("POINTS, CELLS, CELL_TYPES, FIELD or POINT_DATA", keyword);
}

// Arrays of the whole file may precede the kind of data set.
bool read_dataset(VtkInput& input) {
  std::string keyword = upper_case(input.text().token());
  while (keyword == "FIELD" || keyword == "METADATA") {
    input.begin_part(keyword);
    if (keyword == "FIELD" && !skip_vtk_field(input)) return false;
    if (keyword == "METADATA") skip_vtk_metadata(input);
    keyword = upper_case(input.text().token());
  }
  if (keyword != "DATASET") return input.text().fail("`DATASET`", keyword);
  const std::string_view kind = input.text().token();
  return upper_case(kind) == "UNSTRUCTURED_GRID" || input.text().fail("`UNSTRUCTURED_GRID`", kind);
}

}  // namespace

Result<MeshFile> read_vtk(std::string_view text, const std::string& path) {
  VtkInput input(text, path);
  if (!input.read_header() || !read_dataset(input)) return input.error();
  VtkFile file{MeshBuilder(path), {}, "", false, false, false};
  std::string data;  // the keyword with which the data of points and cells begin
  while (data.empty() && !input.text().at_end()) {
    const std::string keyword = upper_case(input.text().token());
    if (keyword == "POINT_DATA" || keyword == "CELL_DATA")
      data = keyword;
    else if (!read_part(input, keyword, file))
      return input.error();
  }
  if (!file.has_points || !file.has_cells || !file.has_types)
    return input.text().problem(
        "expected POINTS, CELLS and CELL_TYPES, found the end of the mesh "
        "without " +
        std::string(!file.has_points  ? "POINTS"
                    : !file.has_cells ? "CELLS"
                                      : "CELL_TYPES"));
  const std::string format = std::string("VTK legacy ") + (input.binary() ? "binary" : "text");
  VtkCellArray array;
  if (!data.empty()) {
    std::string unread;
    array = read_region_array(input, data, unread);
    if (!unread.empty()) file.builder.add_note("the data of points and cells end here: " + unread);
  }
  const std::string complaint = add_vtk_cells(file.cells, file.builder);
  if (!complaint.empty()) return content_error(file.cells_part + ": " + complaint);
  if (!array.name.empty()) set_vtk_regions(file.cells, array.name, array.values, file.builder);
  return file.builder.finish(format);
}

}  // namespace tremolo
