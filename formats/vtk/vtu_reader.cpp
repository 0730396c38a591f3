#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/file/input_file.h"
#include "formats/file/named_below.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/vtk/vtu_data.h"

namespace tremolo {
namespace {

// The pieces of a grid are read into one mesh. Each has points of its own: those of a piece that
// lie exactly where one of an earlier piece of the same file lies are that point.
struct VtuGrid {
  MeshBuilder builder;
  VtkCells cells;
  std::vector<double> regions;  // of the array `region_name`, one per cell
  std::string region_name;      // empty: none
  std::string region_problem;   // why the regions are not used; empty: they are
  std::map<std::array<double, 3>, std::int64_t> id_of_place;  // of earlier pieces; empty for one
  std::size_t pieces = 0;
  std::size_t shared = 0;  // points that are in an earlier piece
  std::size_t ghosts = 0;  // cells that are left out
};

// VTK's bit of a cell that belongs to another piece (vtkDataSetAttributes::DUPLICATECELL).
constexpr std::int64_t kDuplicateCell = 1;

std::string quoted_name(const char* name) {
  return "`" + std::string(name) + "`";
}

Result<pugi::xml_node> find_array(const VtuDocument& document, pugi::xml_node parent,
                                  const char* name) {
  const pugi::xml_node node = *name != '\0'
                                  ? parent.find_child_by_attribute("DataArray", "Name", name)
                                  : parent.child("DataArray");
  if (node) return node;
  return content_error(document.path + ": expected a DataArray of " +
                       (*name != '\0' ? name : "points") + ", found none");
}

// Counts of a piece, bounded by the size of the file.
Result<std::size_t> read_count(const VtuDocument& document, pugi::xml_node piece,
                               const char* name) {
  const std::string value = piece.attribute(name).value();
  TextScanner scanner(value, document.path + ", attribute " + name, {.open_end = true});
  std::size_t count = 0;
  if (!scanner.read(count, "a count")) return scanner.error();
  if (count > document.most_numbers)
    return scanner.problem("expected a count of at most " + std::to_string(document.most_numbers) +
                           ", which fits in the file, found " + value);
  return count;
}

// id_of_point: the mesh's number of each point of the piece.
Status read_points(const VtuDocument& document, pugi::xml_node piece, bool several, VtuGrid& grid,
                   std::vector<std::int64_t>& id_of_point) {
  const Result<std::size_t> count = read_count(document, piece, "NumberOfPoints");
  if (!count) return count.error();
  const Result<pugi::xml_node> node = find_array(document, piece.child("Points"), "");
  if (!node) return node.error();
  std::vector<double> coordinates;
  const Status status = read_vtu_array(document, *node, "`points`", 3 * *count, coordinates);
  if (!status) return status;
  std::vector<std::pair<std::array<double, 3>, std::int64_t>> own;
  for (std::size_t p = 0; p < *count; ++p) {
    const Eigen::Vector3d x(coordinates.data() + 3 * p);
    const std::array<double, 3> place = {x[0], x[1], x[2]};
    const auto known = grid.id_of_place.find(place);
    if (known != grid.id_of_place.end()) {
      id_of_point.push_back(known->second);
      ++grid.shared;
      continue;
    }
    const std::int64_t id = grid.builder.vertex_count();
    if (!grid.builder.add_vertex(id, x))
      return content_error(document.path + ", array `points`: " + grid.builder.complaint());
    id_of_point.push_back(id);
    if (several) own.emplace_back(place, id);
  }
  grid.id_of_place.insert(own.begin(), own.end());
  return Success{};
}

// The cell array that numbers regions, if there is one. A fault in it is noted: the mesh does not
// need it.
void read_regions(const VtuDocument& document, pugi::xml_node piece, std::size_t count,
                  VtuGrid& grid) {
  int best = std::numeric_limits<int>::max();
  pugi::xml_node chosen;
  for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
    const int rank = region_rank(array.attribute("Name").value());
    if (rank < 0 || rank >= best || array.attribute("NumberOfComponents").as_int(1) > 1) continue;
    best = rank;
    chosen = array;
  }
  const std::string name = chosen.attribute("Name").value();
  if (grid.cells.types.size() == count) grid.region_name = name;
  if (grid.region_name.empty() && name.empty()) return;
  if (name != grid.region_name) {
    if (grid.region_problem.empty())
      grid.region_problem = "the pieces have different arrays for them";
    return;
  }
  std::vector<double> values;
  const Status status = read_vtu_array(document, chosen, quoted_text(name), count, values);
  if (status)
    grid.regions.insert(grid.regions.end(), values.begin(), values.end());
  else if (grid.region_problem.empty())
    grid.region_problem = status.error().message;
}

// Which cells are another piece's; empty: none. Pieces of parallel programs overlap by such cells.
Status read_ghosts(const VtuDocument& document, pugi::xml_node piece, std::size_t count,
                   std::vector<bool>& ghosts) {
  const pugi::xml_node node =
      piece.child("CellData").find_child_by_attribute("DataArray", "Name", "vtkGhostType");
  if (!node) return Success{};
  std::vector<std::int64_t> values;
  if (Status s = read_vtu_array(document, node, "`vtkGhostType`", count, values); !s) return s;
  for (const std::int64_t value : values) ghosts.push_back((value & kDuplicateCell) != 0);
  return Success{};
}

// `cells` have passed append_vtk_cells()' checks of their offsets.
void leave_out(const std::vector<bool>& ghosts, std::size_t first, VtuGrid& grid) {
  VtkCells& cells = grid.cells;
  const bool with_regions = grid.regions.size() == cells.types.size();
  std::size_t kept = first;
  std::int64_t end = cells.offsets[first];
  for (std::size_t c = 0; c < ghosts.size(); ++c) {
    if (ghosts[c]) {
      ++grid.ghosts;
      continue;
    }
    for (std::int64_t n = cells.offsets[first + c]; n < cells.offsets[first + c + 1]; ++n)
      cells.connectivity[end++] = cells.connectivity[n];
    cells.types[kept] = cells.types[first + c];
    if (with_regions) grid.regions[kept] = grid.regions[first + c];
    cells.offsets[++kept] = end;
  }
  cells.offsets.resize(kept + 1);
  cells.types.resize(kept);
  cells.connectivity.resize(end);
  if (with_regions) grid.regions.resize(kept);
}

Status read_list(const VtuDocument& document, pugi::xml_node cells, const char* name,
                 std::size_t count, std::vector<std::int64_t>& values) {
  const Result<pugi::xml_node> node = find_array(document, cells, name);
  if (!node) return node.error();
  return read_vtu_array(document, *node, quoted_name(name), count, values);
}

Status read_cells(const VtuDocument& document, pugi::xml_node piece,
                  const std::vector<std::int64_t>& id_of_point, VtuGrid& grid) {
  const Result<std::size_t> count = read_count(document, piece, "NumberOfCells");
  if (!count) return count.error();
  const pugi::xml_node cells = piece.child("Cells");
  VtkCells found;
  Status status = read_list(document, cells, "offsets", *count, found.offsets);
  if (status) status = read_list(document, cells, "types", *count, found.types);
  if (!status) return status;
  // VTU leaves out the first offset, 0; the last is the length of the list of nodes.
  found.offsets.insert(found.offsets.begin(), 0);
  const std::int64_t length = found.offsets.back();
  if (length < 0 || std::cmp_greater(length, document.most_numbers))
    return content_error(document.path + ", array `offsets`: expected a last offset of at most " +
                         std::to_string(document.most_numbers) +
                         ", which fits in the file, found " + std::to_string(length));
  status = read_list(document, cells, "connectivity", length, found.connectivity);
  if (!status) return status;
  const std::size_t first = grid.cells.types.size();
  const std::string complaint = append_vtk_cells(found, id_of_point, grid.cells);
  if (!complaint.empty()) return content_error(document.path + ": " + complaint);
  read_regions(document, piece, *count, grid);
  std::vector<bool> ghosts;
  if (Status s = read_ghosts(document, piece, *count, ghosts); !s) return s;
  if (!ghosts.empty()) leave_out(ghosts, first, grid);
  return Success{};
}

bool is_empty(pugi::xml_node piece) {
  return piece.attribute("NumberOfPoints").value() == std::string_view("0") &&
         piece.attribute("NumberOfCells").value() == std::string_view("0");
}

// All pieces of a file that has their data.
Status read_pieces(const VtuDocument& document, VtuGrid& grid) {
  const pugi::xml_node first = document.root().child("UnstructuredGrid").child("Piece");
  if (!first) return content_error(document.path + ": expected a Piece, found none");
  const bool several = static_cast<bool>(first.next_sibling("Piece"));
  grid.id_of_place.clear();
  const auto numbers = [&grid] {
    return grid.cells.connectivity.size() + grid.builder.vertex_count() + grid.shared;
  };
  const std::size_t before = numbers();
  std::size_t own = 0;
  for (pugi::xml_node piece = first; piece; piece = piece.next_sibling("Piece")) {
    ++grid.pieces;
    ++own;
    if (is_empty(piece)) continue;
    std::vector<std::int64_t> id_of_point;
    Status status = read_points(document, piece, several, grid, id_of_point);
    if (status) status = read_cells(document, piece, id_of_point, grid);
    if (!status) return status;
    // Pieces may name the same appended bytes: together they still fit in the file.
    if (numbers() > before + 2 * document.most_numbers)
      return content_error(document.path + ": expected pieces that fit in the file, found " +
                           std::to_string(own) + " pieces of more numbers");
  }
  return Success{};
}

// The pieces of a PUnstructuredGrid are files. Their points stay apart: those that coincide are
// counted with those of other meshes, and joined if that is asked for.
Status read_named_pieces(const VtuDocument& list, VtuGrid& grid) {
  const pugi::xml_node all = list.root().child("PUnstructuredGrid");
  if (!all.child("Piece")) return content_error(list.path + ": expected a Piece, found none");
  std::set<std::string> read;
  for (const pugi::xml_node piece : all.children("Piece")) {
    const std::string name = piece.attribute("Source").value();
    const std::optional<std::string> path = named_below(list.path, name);
    if (!path || !read.insert(*path).second)
      return content_error(list.path +
                           ": expected a Piece with Source=FILE of a file in the same folder or "
                           "below, each once, found " +
                           quoted_text(name));
    const Result<std::string> text = read_whole_file(*path);
    if (!text)
      return Error{text.error().kind, text.error().message + " (a piece of " + list.path + ")"};
    VtuDocument document;
    Status status = open_vtu(*text, *path, document);
    if (status && document.partitioned)
      return content_error(list.path + ": its piece " + quoted_text(name) +
                           " is partitioned itself: expected one that has its points and cells");
    if (status) status = read_pieces(document, grid);
    if (!status) return status;
  }
  return Success{};
}

std::string pieces_note(const VtuGrid& grid, bool partitioned) {
  const std::string pieces = std::to_string(grid.pieces) + " pieces are one mesh";
  return partitioned
             ? pieces + "; each keeps points of its own, which --merge joins where they coincide"
             : pieces + ": " + std::to_string(grid.shared) +
                   " points that lie where an earlier piece has one are taken once";
}

}  // namespace

Result<MeshFile> read_vtu(std::string_view text, const std::string& path) {
  VtuDocument document;
  Status status = open_vtu(text, path, document);
  if (!status) return status.error();
  VtuGrid grid{MeshBuilder(path), {}, {}, {}, {}, {}};
  status = document.partitioned ? read_named_pieces(document, grid) : read_pieces(document, grid);
  if (!status) return status.error();
  if (!grid.builder.seal_vertices()) return content_error(path + ": " + grid.builder.complaint());
  if (grid.pieces > 1) grid.builder.add_note(pieces_note(grid, document.partitioned));
  if (grid.ghosts > 0)
    grid.builder.add_note(std::to_string(grid.ghosts) +
                          " ghost cells, which are other pieces' as well, are left out");
  const std::string complaint = add_vtk_cells(grid.cells, grid.builder);
  if (!complaint.empty()) return content_error(path + ": " + complaint);
  if (!grid.region_problem.empty())
    grid.builder.add_note("the regions are not read: " + grid.region_problem);
  else if (!grid.region_name.empty())
    set_vtk_regions(grid.cells, grid.region_name, grid.regions, grid.builder);
  return grid.builder.finish("VTU");
}

}  // namespace tremolo
