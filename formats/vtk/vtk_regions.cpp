#include "formats/vtk/vtk_regions.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "formats/file/text_scanner.h"
#include "formats/mesh/mesh_cells.h"

namespace tremolo {
namespace {

constexpr std::string_view kRegionArrays[] = {"material",  "region",     "gmsh:physical",
                                              "medit:ref", "cellentity", "subdomain"};
constexpr double kMostExact = 9007199254740992.0;  // 2^53: beyond, doubles skip integers

// "Material_IDs" -> "material".
std::string plain_name(std::string_view array) {
  std::string name;
  for (char c : array) {
    if (c == '_' || c == ' ' || c == '-') continue;
    name += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  for (const std::string_view ending : {"s", "id"})
    if (name.ends_with(ending)) name.resize(name.size() - ending.size());
  return name;
}

}  // namespace

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
                     " cells: it names no regions");
    return;
  }
  std::vector<std::int64_t> labels;
  for (std::size_t c = 0; c < values.size(); ++c) {
    const std::int64_t type = cells.types[c];
    const CellKind* kind = type < 0 || type > 255 ? nullptr : vtk_cell(static_cast<int>(type));
    if (kind == nullptr || kind->role != CellKind::Role::kTetrahedron) continue;
    if (!(std::abs(values[c]) <= kMostExact) || values[c] != std::floor(values[c])) {
      builder.add_note("cell data " + quoted_text(array) +
                       " holds numbers that are not integers: it names no regions");
      return;
    }
    labels.push_back(static_cast<std::int64_t>(values[c]));
  }
  builder.set_regions(labels, [](std::int64_t label) { return "region " + std::to_string(label); });
  builder.add_note("cell data " + quoted_text(array) + " gives the regions");
}

}  // namespace tremolo
