#include "formats/vtk/vtk_cells.h"

namespace tremolo {
namespace {

std::string check_offsets(const VtkCells& cells) {
  if (cells.offsets.empty() || cells.offsets.size() - 1 != cells.types.size())
    return "expected as many cell types as cells, found " + std::to_string(cells.types.size()) +
           " types of " + std::to_string(cells.offsets.empty() ? 0 : cells.offsets.size() - 1) +
           " cells";
  const auto end = static_cast<std::int64_t>(cells.connectivity.size());
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

std::string add_vtk_cells(const VtkCells& cells, MeshBuilder& builder) {
  std::string complaint = check_offsets(cells);
  if (!complaint.empty()) return complaint;
  std::vector<VertexId> vertices;
  for (std::size_t c = 0; c < cells.types.size(); ++c) {
    const std::int64_t type = cells.types[c];
    const CellKind* kind = type < 0 || type > 255 ? nullptr : vtk_cell(static_cast<int>(type));
    if (kind == nullptr)
      return "cell " + std::to_string(c) + " has type " + std::to_string(type) +
             ", expected a cell type of VTK";
    const auto first = static_cast<std::size_t>(cells.offsets[c]);
    const auto count = static_cast<std::size_t>(cells.offsets[c + 1]) - first;
    if (kind->nodes != 0 && count != static_cast<std::size_t>(kind->nodes))
      return "cell " + std::to_string(c) + " is one of " + std::string(kind->plural) +
             ", expected " + std::to_string(kind->nodes) + " nodes, found " + std::to_string(count);
    const auto id = static_cast<std::int64_t>(c);
    if (!builder.resolve(id, {cells.connectivity.data() + first, count}, vertices) ||
        !builder.add_cell(id, *kind, vertices))
      return builder.complaint();
  }
  return "";
}

}  // namespace tremolo
