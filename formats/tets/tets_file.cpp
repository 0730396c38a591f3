#include "formats/tets/tets_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

#include "formats/sections/section_file.h"
#include "formats/sections/section_writer.h"
#include "formats/tets/tets_layout.h"

namespace tremolo {
namespace {

namespace layout = tets_layout;
using layout::ElementType;
using layout::SectionShape;

using TetsCounts = std::array<std::uint64_t, layout::kCountsSize>;
using MaterialRow = std::array<double, layout::kMaterialSize>;

std::uint64_t grid_size(const TetsCounts& counts) {
  return counts[6] * counts[7] * counts[8];
}

std::vector<SectionShape> tets_shapes(const TetsCounts& n) {
  return {
      {layout::kCounts, ElementType::kU64, layout::kCountsSize, 1, true},
      {layout::kVertices, ElementType::kF64, n[0], 3, true},
      {layout::kTetrahedra, ElementType::kU32, n[1], 4, true},
      {layout::kMaterials, ElementType::kF64, n[2], layout::kMaterialSize, true},
      {layout::kMaterialOf, ElementType::kU32, n[1], 1, true},
      {layout::kHeld, ElementType::kU32, n[3], 1},
      {layout::kDrawnVertices, ElementType::kF64, n[4], 3, false, layout::kDrawnWeights},
      {layout::kDrawnTriangles, ElementType::kU32, n[5], 3, false, layout::kDrawnVertices},
      {layout::kDrawnTetrahedra, ElementType::kU32, n[4], 1, false, layout::kDrawnVertices},
      {layout::kDrawnWeights, ElementType::kF64, n[4], 4, false, layout::kDrawnTetrahedra},
      {layout::kDrawnUvs, ElementType::kF32, n[4], 2, false, layout::kDrawnVertices},
      {layout::kDrawnSources, ElementType::kU32, n[4], 1, false, layout::kDrawnVertices},
      {layout::kGridFrame, ElementType::kF64, layout::kGridFrameSize, 1, false, layout::kDistances},
      {layout::kDistances, ElementType::kF32, grid_size(n), 1, false, layout::kGridFrame},
      {layout::kProvenance, ElementType::kU8, layout::kAnyRows, 1}};
}

MaterialRow to_row(const Material& material) {
  MaterialRow row{material.young, material.poisson, material.density, 0.0};
  if (!material.orthotropic) return row;
  const OrthotropicElasticity& o = *material.orthotropic;
  row[3] = 1.0;
  for (int i = 0; i < 3; ++i) {
    row[4 + i] = o.young[i];
    row[7 + i] = o.poisson[i];
    row[10 + i] = o.shear[i];
    for (int j = 0; j < 3; ++j) row[13 + 3 * j + i] = o.axes(i, j);
  }
  return row;
}

Material from_row(const double* row) {
  Material material{row[0], row[1], row[2]};
  if (row[3] == 0.0) return material;
  OrthotropicElasticity o;
  for (int i = 0; i < 3; ++i) {
    o.young[i] = row[4 + i];
    o.poisson[i] = row[7 + i];
    o.shear[i] = row[10 + i];
    for (int j = 0; j < 3; ++j) o.axes(i, j) = row[13 + 3 * j + i];
  }
  material.orthotropic = o;
  return material;
}

// Values in the list of sections that are not in the caller's data.
struct TetsNumbers {
  TetsCounts counts{};
  std::vector<MaterialRow> materials;
  std::vector<std::uint32_t> material_of;
  std::array<double, layout::kGridFrameSize> frame{};
};

TetsNumbers numbers_of_tets(const TetsData& data) {
  TetsNumbers numbers;
  const GridNodes& grid = data.nodes;
  const bool touches = !data.distances.empty();
  numbers.counts = {data.mesh.vertices.size(),       data.mesh.tetrahedra.size(),
                    data.materials.materials.size(), data.held.size(),
                    data.surface.vertices.size(),    data.surface.triangles.size(),
                    touches ? grid.counts[0] : 0U,   touches ? grid.counts[1] : 0U,
                    touches ? grid.counts[2] : 0U};
  for (const NamedMaterial& named : data.materials.materials)
    numbers.materials.push_back(to_row(named.material));
  numbers.material_of.assign(data.mesh.tetrahedra.size(), 0);
  std::copy(data.materials.of_tet.begin(), data.materials.of_tet.end(),
            numbers.material_of.begin());
  numbers.frame = {grid.origin.x(), grid.origin.y(), grid.origin.z(), grid.spacing};
  return numbers;
}

template <class Use>
auto with_tets_sections(const TetsData& data, const Use& use) -> decltype(use(SectionList{})) {
  if (const auto fault = find_tets_fault(data.mesh, data.materials, data.held, data.surface))
    return content_error(std::string(fault->section) + ": " + fault->problem);
  if (!data.distances.empty())
    if (const auto grid = DistanceGrid::create(data.nodes, data.distances); !grid)
      return grid.error();
  const TetsNumbers numbers = numbers_of_tets(data);
  std::vector<SectionShape> shapes = tets_shapes(numbers.counts);
  shapes.back().rows = data.provenance.size();
  const std::array<std::span<const std::byte>, 15> bytes = {
      bytes_of(numbers.counts),          bytes_of(data.mesh.vertices),
      bytes_of(data.mesh.tetrahedra),    bytes_of(numbers.materials),
      bytes_of(numbers.material_of),     bytes_of(data.held),
      bytes_of(data.surface.vertices),   bytes_of(data.surface.triangles),
      bytes_of(data.surface.tetrahedra), bytes_of(data.surface.weights),
      bytes_of(data.surface.uvs),        bytes_of(data.surface.sources),
      bytes_of(numbers.frame),           bytes_of(data.distances),
      bytes_of(data.provenance)};
  SectionList list{layout::kKind, layout::kMinor, {}};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const bool of_grid = shapes[i].name == layout::kGridFrame && data.distances.empty();
    if (!bytes[i].empty() && !of_grid) list.sections.push_back({shapes[i], bytes[i]});
  }
  return use(list);
}

// Copies a section's elements, as many as the target's rows hold; does nothing without the section.
template <class Element, class Row>
Status read_rows(SectionFile& file, std::string_view name, std::vector<Row>& rows) {
  if (!file.has(name)) return Success{};
  const Result<std::span<const Element>> values = file.elements<Element>(name);
  if (!values) return values.error();
  rows.resize(values->size_bytes() / sizeof(Row));
  if (!rows.empty())
    std::memcpy(static_cast<void*>(rows.data()), values->data(), values->size_bytes());
  return Success{};
}

Result<TetsCounts> read_counts(SectionFile& file) {
  if (!file.has(layout::kCounts) ||
      file.find(layout::kCounts)->size != layout::kCountsSize * sizeof(std::uint64_t))
    return file.error_at("table", layout::kHeaderSize,
                         "section 'counts' is missing or has another shape");
  const auto values = file.elements<std::uint64_t>(layout::kCounts);
  if (!values) return values.error();
  TetsCounts counts;
  std::copy(values->begin(), values->end(), counts.begin());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::uint64_t most = i < 6 ? std::uint64_t{1} << 31 : kMostGridNodes;
    if (counts[i] > most)
      return file.error_at(
          layout::kCounts, file.find(layout::kCounts)->offset + 8 * i,
          "a count is " + std::to_string(counts[i]) + ", at most " + std::to_string(most));
  }
  return counts;
}

Status read_grid(SectionFile& file, const TetsCounts& counts, TetsFile& read) {
  if (!file.has(layout::kDistances)) return Success{};
  const auto frame = file.finite<double>(layout::kGridFrame);
  if (!frame) return frame.error();
  const auto distances = file.finite<float>(layout::kDistances);
  if (!distances) return distances.error();
  GridNodes nodes;
  nodes.origin = {(*frame)[0], (*frame)[1], (*frame)[2]};
  nodes.spacing = (*frame)[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
    nodes.counts[axis] = static_cast<std::uint32_t>(counts[6 + axis]);
  Result<DistanceGrid> grid = DistanceGrid::create(nodes, *distances);
  if (!grid)
    return file.error_at(layout::kDistances, file.find(layout::kDistances)->offset,
                         grid.error().message);
  read.grid.emplace(std::move(*grid));
  return Success{};
}

Status read_mesh_sections(SectionFile& file, TetsFile& read) {
  static_assert(sizeof(Eigen::Vector3d) == 24 && sizeof(Tetrahedron) == 16);
  if (Status s = read_rows<double>(file, layout::kVertices, read.mesh.vertices); !s) return s;
  if (Status s = read_rows<std::uint32_t>(file, layout::kTetrahedra, read.mesh.tetrahedra); !s)
    return s;
  std::vector<MaterialRow> rows;
  if (Status s = read_rows<double>(file, layout::kMaterials, rows); !s) return s;
  for (std::size_t k = 0; k < rows.size(); ++k)
    read.materials.materials.push_back({"material " + std::to_string(k), from_row(rows[k].data())});
  if (Status s = read_rows<std::uint32_t>(file, layout::kMaterialOf, read.materials.of_tet); !s)
    return s;
  return read_rows<std::uint32_t>(file, layout::kHeld, read.held);
}

Status read_surface_sections(SectionFile& file, TetsSurface& surface) {
  if (Status s = read_rows<double>(file, layout::kDrawnVertices, surface.vertices); !s) return s;
  if (Status s = read_rows<std::uint32_t>(file, layout::kDrawnTriangles, surface.triangles); !s)
    return s;
  if (Status s = read_rows<std::uint32_t>(file, layout::kDrawnTetrahedra, surface.tetrahedra); !s)
    return s;
  if (Status s = read_rows<double>(file, layout::kDrawnWeights, surface.weights); !s) return s;
  if (Status s = read_rows<float>(file, layout::kDrawnUvs, surface.uvs); !s) return s;
  return read_rows<std::uint32_t>(file, layout::kDrawnSources, surface.sources);
}

Result<TetsFile> read_tets_sections(Result<SectionFile> file) {
  if (!file) return file.error();
  const Result<TetsCounts> counts = read_counts(*file);
  if (!counts) return counts.error();
  if (Status s = file->check_shapes(tets_shapes(*counts)); !s) return s.error();
  TetsFile read;
  if (Status s = read_mesh_sections(*file, read); !s) return s.error();
  if (Status s = read_surface_sections(*file, read.surface); !s) return s.error();
  if (const auto fault = find_tets_fault(read.mesh, read.materials, read.held, read.surface)) {
    const FileSection* section = file->find(fault->section);
    return file->error_at(fault->section, section == nullptr ? 0 : section->offset, fault->problem);
  }
  if (Status s = read_grid(*file, *counts, read); !s) return s.error();
  if (file->has(layout::kProvenance))
    if (Status s = take(read.provenance, file->text(layout::kProvenance)); !s) return s.error();
  return read;
}

}  // namespace

Result<std::vector<std::byte>> encode_tets(const TetsData& data) {
  return with_tets_sections(data, [](const SectionList& list) { return encode_sections(list); });
}

Status write_tets(const std::string& path, const TetsData& data) {
  return with_tets_sections(
      data, [&path](const SectionList& list) { return write_sections(path, list); });
}

Result<TetsFile> read_tets(const std::string& path) {
  return read_tets_sections(SectionFile::open(path, layout::kKind));
}

Result<TetsFile> read_tets(std::span<const std::byte> bytes, const std::string& name) {
  return read_tets_sections(SectionFile::from_memory(bytes, name, layout::kKind));
}

}  // namespace tremolo
