#include "formats/vtk/vtk_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/packed_index.h"
#include "common/text.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_cells.h"

namespace tremolo {
namespace {

constexpr std::string_view kRegionArrays[] = {"material",  "region",     "gmsh:physical",
                                              "medit:ref", "cellentity", "subdomain"};

// "Material_IDs" -> "material".
std::string plain_name(std::string_view array) {
  std::string name = lower_case(array);
  std::erase_if(name, [](char c) { return c == '_' || c == ' ' || c == '-'; });
  for (const std::string_view ending : {"s", "id"})
    if (name.ends_with(ending)) name.resize(name.size() - ending.size());
  return name;
}

std::string check_offsets(const VtkCells& cells) {
  if (cells.offsets.empty() || cells.offsets.size() - 1 != cells.types.size())
    return "expected as many cell types as cells, found " + std::to_string(cells.types.size()) +
           " types of " + std::to_string(cells.offsets.empty() ? 0 : cells.offsets.size() - 1) +
           " cells";
  const std::int64_t end = cells.connectivity.size();
  if (cells.offsets.front() != 0 || cells.offsets.back() != end)
    return "expected cell offsets from 0 to " + std::to_string(end) + ", found " +
           std::to_string(cells.offsets.front()) + " to " + std::to_string(cells.offsets.back());
  for (std::size_t c = 0; c + 1 < cells.offsets.size(); ++c)
    if (cells.offsets[c] > cells.offsets[c + 1])
      return "the offset of cell " + std::to_string(c) + " is " + std::to_string(cells.offsets[c]) +
             ", expected at most that of the next, " + std::to_string(cells.offsets[c + 1]);
  return "";
}

}  // namespace

std::string append_vtk_cells(const VtkCells& piece, std::span<const std::int64_t> id_of_point,
                             VtkCells& cells) {
  const std::string complaint = check_offsets(piece);
  if (!complaint.empty()) return complaint;
  const std::int64_t before = cells.connectivity.size();
  if (cells.offsets.empty()) cells.offsets.push_back(0);
  for (std::size_t c = 0; c < piece.types.size(); ++c)
    cells.offsets.push_back(before + piece.offsets[c + 1]);
  for (const std::int64_t point : piece.connectivity) {
    if (!is_index(point, id_of_point.size()))
      return "a cell refers to point " + std::to_string(point) + ", expected one of the " +
             std::to_string(id_of_point.size()) + " points of its piece";
    cells.connectivity.push_back(id_of_point[point]);
  }
  cells.types.insert(cells.types.end(), piece.types.begin(), piece.types.end());
  return "";
}

std::string add_vtk_cells(VtkCells& cells, MeshBuilder& builder) {
  std::string complaint = check_offsets(cells);
  if (!complaint.empty()) return complaint;
  std::vector<VertexId> vertices;
  for (std::size_t c = 0; c < cells.types.size(); ++c) {
    const std::int64_t type = cells.types[c];
    const CellKind* kind = vtk_cell(type);
    if (kind == nullptr)
      return "cell " + std::to_string(c) + " has type " + std::to_string(type) +
             ", expected a cell type of VTK";
    const std::size_t first = cells.offsets[c];
    const std::size_t count = cells.offsets[c + 1] - first;
    if (kind->nodes != 0 && std::cmp_not_equal(count, kind->nodes))
      return "cell " + std::to_string(c) + " is one of " + std::string(kind->plural) +
             ", expected " + std::to_string(kind->nodes) + " nodes, found " + std::to_string(count);
    const std::int64_t id = c;
    const std::size_t before = builder.mesh().tetrahedra.size();
    if (!builder.resolve(id, {cells.connectivity.data() + first, count}, vertices) ||
        !builder.add_cell(id, *kind, vertices))
      return builder.complaint();
    cells.tetrahedra.push_back(
        static_cast<std::uint8_t>(builder.mesh().tetrahedra.size() - before));
  }
  return "";
}

int region_rank(std::string_view array) {
  const std::string name = plain_name(array);
  int rank = 0;
  for (const std::string_view known : kRegionArrays) {
    if (name == known) return rank;
    ++rank;
  }
  return -1;
}

void set_vtk_regions(const VtkCells& cells, const std::string& array,
                     std::span<const double> values, MeshBuilder& builder) {
  if (values.size() != cells.types.size()) {
    builder.add_note("cell data " + quoted_text(array) + " has " + std::to_string(values.size()) +
                     " numbers for " + std::to_string(cells.types.size()) +
                     " cells: it is not used for regions");
    return;
  }
  std::vector<std::int64_t> labels;
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (cells.tetrahedra[c] == 0) continue;
    if (!(std::abs(values[c]) <= kMostExact) || values[c] != std::floor(values[c])) {
      builder.add_note("cell data " + quoted_text(array) +
                       " holds numbers that are not integers: it is not used for regions");
      return;
    }
    labels.insert(labels.end(), cells.tetrahedra[c], static_cast<std::int64_t>(values[c]));
  }
  builder.set_regions(labels, [](std::int64_t label) { return "region " + std::to_string(label); });
  builder.add_note("cell data " + quoted_text(array) + " gives the regions");
}

}  // namespace tremolo
