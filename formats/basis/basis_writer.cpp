#include "formats/basis/basis_writer.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "common/hash.h"
#include "common/packed_index.h"
#include "formats/basis/basis_layout.h"
#include "formats/basis/compact_values.h"
#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

using namespace basis_layout;
static_assert(std::endian::native == std::endian::little, "values are written as they lie");

// A section to come: its bytes stay where they are in the caller's data, or come from a source.
struct Section {
  std::string_view name;
  ElementType type;
  bool critical;
  std::uint64_t rows;
  std::uint64_t columns;
  std::span<const std::byte> bytes;
  const RowSource* source = nullptr;

  std::size_t size() const {
    return source == nullptr ? bytes.size() : sizeof(double) * rows * columns;
  }
};

template <class T>
std::span<const std::byte> bytes_of(const T* data, std::size_t count) {
  return std::as_bytes(std::span<const T>(data, count));
}

std::span<const std::byte> ids_of(const std::vector<VertexId>& ids) {
  static_assert(sizeof(VertexId) == 4);
  return bytes_of(ids.data(), ids.size());
}

std::span<const std::byte> points_of(const std::vector<Eigen::Vector3d>& points) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return std::as_bytes(std::span(points));
}

bool is_linear(const BasisData& data) {
  return data.cubic.empty() && data.quartic.empty();
}

// streamed: the rows come from elsewhere.
Status check_shapes(const BasisData& data, bool streamed) {
  const auto r = static_cast<std::size_t>(data.lambda.size());
  const auto bad = [](const char* member) {
    return content_error(std::string("basis data: the size of '") + member +
                         "' does not fit the others");
  };
  if (r == 0 || r > kMaxModes) return bad("lambda");
  if (!is_linear(data)) {
    if (data.cubic.size() != triple_count(r)) return bad("cubic");
    if (data.quartic.size() != quad_count(r)) return bad("quartic");
  }
  for (const auto& [block, name] :
       {std::pair{&data.surface, "surface"}, {&data.interior, "interior"}}) {
    const std::size_t count = block->vertex_ids.size();
    if (block->rest.size() != count) return bad(name);
    if (!streamed && (block->rows.rows() != static_cast<Eigen::Index>(3 * count) ||
                      (count > 0 && block->rows.cols() != static_cast<Eigen::Index>(r))))
      return bad(name);
  }
  if (data.surface.vertex_ids.size() + data.interior.vertex_ids.size() != data.vertex_count ||
      data.vertex_count > kMaxVertices)
    return bad("vertex_count");
  if (data.fixed_vertices.size() != data.fixed_vertex_count) return bad("fixed_vertices");
  if (data.load.vertices.size() != data.load.forces.size()) return bad("load");
  if (data.render && !streamed && !fits(*data.render, data.lambda.size(), data.vertex_count))
    return bad("render");
  return Success{};
}

// Where the rounded numbers of a compact file live while its sections are written.
struct CompactArrays {
  std::vector<double> coefficient_scales;
  std::vector<double> basis_scales;
  std::vector<float> cubic;
  std::vector<float> quartic;
  std::vector<std::int16_t> surface;
  std::vector<std::int16_t> interior;
  std::vector<std::int16_t> render;
};

// Each ended by a zero byte.
std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(name).push_back('\0');
  return text;
}

// The names as they lie in the file.
struct RenderNames {
  std::string objects;
  std::string materials;
};

Result<CompactArrays> make_compact(const BasisData& data) {
  Result<ScaledFloats> cubic = to_scaled_floats(data.cubic, "cubic");
  if (!cubic) return cubic.error();
  Result<ScaledFloats> quartic = to_scaled_floats(data.quartic, "quartic");
  if (!quartic) return quartic.error();
  std::vector<NamedRows> blocks = {{&data.surface.rows, "surface"},
                                   {&data.interior.rows, "interior"}};
  if (data.render) blocks.push_back({&data.render->rows, "render"});
  Result<std::vector<double>> scales =
      column_scales(blocks, static_cast<std::size_t>(data.lambda.size()));
  if (!scales) return scales.error();
  CompactArrays arrays;
  arrays.surface = to_scaled_integers(data.surface.rows, *scales);
  arrays.interior = to_scaled_integers(data.interior.rows, *scales);
  if (data.render) arrays.render = to_scaled_integers(data.render->rows, *scales);
  arrays.basis_scales = std::move(*scales);
  arrays.coefficient_scales = {cubic->scale, quartic->scale};
  arrays.cubic = std::move(cubic->values);
  arrays.quartic = std::move(quartic->values);
  return arrays;
}

// compact: null for a full file.
void add_render_sections(const RenderBlock& render, std::uint64_t r, const RenderNames& names,
                         const CompactArrays* compact, std::vector<Section>& sections) {
  const RenderSurface& surface = render.surface;
  const std::uint64_t v = surface.vertices.size();
  const std::uint64_t w = surface.triangles.size();
  const auto u32 = ElementType::kU32;
  const auto f32 = ElementType::kF32;
  const auto u8 = ElementType::kU8;
  const auto bytes = [](const auto& list) { return std::as_bytes(std::span(list)); };
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  static_assert(sizeof(Eigen::Vector2f) == 2 * sizeof(float));
  const auto add = [&](std::string_view name, ElementType type, std::uint64_t rows,
                       std::uint64_t columns, std::span<const std::byte> contents) {
    sections.push_back({name, type, false, rows, columns, contents});
  };
  add(kRenderRest, ElementType::kF64, v, 3, points_of(surface.vertices));
  add(kRenderBasis, compact != nullptr ? ElementType::kI16 : ElementType::kF64, 3 * v, r,
      compact != nullptr
          ? bytes(compact->render)
          : bytes_of(render.rows.data(), static_cast<std::size_t>(render.rows.size())));
  add(kRenderAnchors, u32, v, 1, ids_of(render.anchors));
  add(kRenderTriangles, u32, w, 3, bytes(surface.triangles));
  add(kRenderObjects, u32, w, 1, bytes(surface.object_of));
  add(kRenderMaterials, u32, w, 1, bytes(surface.material_of));
  add(kObjectNames, u8, names.objects.size(), 1, bytes(names.objects));
  add(kMaterialNames, u8, names.materials.size(), 1, bytes(names.materials));
  if (!surface.normals.empty()) add(kRenderNormals, f32, v, 3, bytes(surface.normals));
  if (!surface.uvs.empty()) add(kRenderUvs, f32, v, 2, bytes(surface.uvs));
  if (!surface.colours.empty()) add(kRenderColours, u8, v, 4, bytes(surface.colours));
}

// compact: null for a full file.
std::vector<Section> list_sections(const BasisData& data, const std::uint64_t* dimensions,
                                   const RenderNames& names, const CompactArrays* compact) {
  const auto r = static_cast<std::uint64_t>(data.lambda.size());
  const std::uint64_t s = data.surface.vertex_ids.size();
  const std::uint64_t inner = data.interior.vertex_ids.size();
  const auto f64 = ElementType::kF64;
  const auto u32 = ElementType::kU32;
  const ElementType coefficient = compact != nullptr ? ElementType::kF32 : f64;
  const ElementType basis = compact != nullptr ? ElementType::kI16 : f64;
  const auto vector = [](const auto& v) { return bytes_of(v.data(), v.size()); };
  const auto coefficients = [&](const std::vector<double>& full,
                                std::vector<float> CompactArrays::*rounded) {
    return compact != nullptr ? vector(compact->*rounded) : vector(full);
  };
  const auto rows = [&](const BasisRows& full, std::vector<std::int16_t> CompactArrays::*rounded) {
    return compact != nullptr ? vector(compact->*rounded)
                              : bytes_of(full.data(), static_cast<std::size_t>(full.size()));
  };
  // What a runtime touches comes first, the interior and the provenance last.
  std::vector<Section> sections = {{kDimensions, ElementType::kU64, true, dimension::kCount, 1,
                                    bytes_of(dimensions, dimension::kCount)},
                                   {kTotalMass, f64, false, 1, 1, bytes_of(&data.total_mass, 1)},
                                   {kLambda, f64, true, r, 1, bytes_of(data.lambda.data(), r)}};
  if (compact != nullptr) {
    sections.push_back({kCoefficientScales, f64, true, coefficient_scale::kCount, 1,
                        vector(compact->coefficient_scales)});
    sections.push_back({kBasisScales, f64, true, r, 1, vector(compact->basis_scales)});
  }
  const std::vector<Section> visible = {
      {kCubic, coefficient, true, data.cubic.size(), 1,
       coefficients(data.cubic, &CompactArrays::cubic)},
      {kQuartic, coefficient, true, data.quartic.size(), 1,
       coefficients(data.quartic, &CompactArrays::quartic)},
      {kLoadIds, u32, false, data.load.vertices.size(), 1, ids_of(data.load.vertices)},
      {kLoadForces, f64, false, data.load.forces.size(), 3, points_of(data.load.forces)},
      {kSurfaceIds, u32, true, s, 1, ids_of(data.surface.vertex_ids)},
      {kTriangles, u32, true, data.triangles.size(), 3,
       bytes_of(data.triangles.data(), data.triangles.size())},
      {kSurfaceRest, f64, true, s, 3, points_of(data.surface.rest)},
      {kSurfaceBasis, basis, true, 3 * s, r, rows(data.surface.rows, &CompactArrays::surface)},
  };
  sections.insert(sections.end(), visible.begin(), visible.end());
  if (data.render) add_render_sections(*data.render, r, names, compact, sections);
  const std::vector<Section> others = {
      {kInteriorIds, u32, false, inner, 1, ids_of(data.interior.vertex_ids)},
      {kInteriorRest, f64, false, inner, 3, points_of(data.interior.rest)},
      {kInteriorBasis, basis, false, 3 * inner, r,
       rows(data.interior.rows, &CompactArrays::interior)},
      {kFixedIds, u32, false, data.fixed_vertices.size(), 1, ids_of(data.fixed_vertices)},
      {kSingularValues, f64, false, data.singular_values.size(), 1, vector(data.singular_values)},
      {kProvenance, ElementType::kU8, false, data.provenance.size(), 1,
       bytes_of(data.provenance.data(), data.provenance.size())},
  };
  sections.insert(sections.end(), others.begin(), others.end());
  for (const auto& [name, bytes] :
       {std::pair{kVegaBasis, &data.vega.basis}, {kVegaCubic, &data.vega.cubic}})
    if (!bytes->empty())
      sections.push_back({name, ElementType::kU8, false, bytes->size(), 1,
                          bytes_of(bytes->data(), bytes->size())});
  return sections;
}

template <class T>
void put(std::vector<std::byte>& file, std::size_t at, T value) {
  std::memcpy(file.data() + at, &value, sizeof(value));
}

std::size_t aligned(std::size_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

void put_entry(std::vector<std::byte>& table, std::size_t at, const Section& section,
               std::size_t offset, std::uint64_t hash) {
  std::memcpy(table.data() + at + entry::kNameAt, section.name.data(), section.name.size());
  put(table, at + entry::kTypeAt, static_cast<std::uint32_t>(section.type));
  put(table, at + entry::kFlagsAt, section.critical ? kCritical : 0u);
  put(table, at + entry::kOffsetAt, static_cast<std::uint64_t>(offset));
  put(table, at + entry::kSizeAt, static_cast<std::uint64_t>(section.size()));
  put(table, at + entry::kRowsAt, section.rows);
  put(table, at + entry::kColumnsAt, section.columns);
  put(table, at + entry::kHashAt, hash);
}

// Takes bytes for a place of the file, in ascending order but for the header, which comes last.
using Sink = std::function<Status(std::size_t offset, std::span<const std::byte> bytes)>;

// The section's bytes to the sink; their hash.
Result<std::uint64_t> put_section(const Section& section, std::size_t offset, const Sink& sink) {
  if (section.source == nullptr) {
    if (Status status = sink(offset, section.bytes); !status) return status.error();
    return hash_bytes(section.bytes);
  }
  const auto vertices = static_cast<std::size_t>(section.rows / 3);
  const auto numbers = static_cast<std::size_t>(3 * section.columns);
  std::vector<double> rows(std::min(vertices, kRowsAtOnce) * numbers);
  Hasher hasher;
  for (std::size_t first = 0; first < vertices; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, vertices - first);
    if (Status status = (*section.source)(first, count, rows.data()); !status)
      return status.error();
    const std::span<const std::byte> bytes = bytes_of(rows.data(), count * numbers);
    hasher.add(bytes);
    if (Status status = sink(offset + first * numbers * sizeof(double), bytes); !status)
      return status.error();
  }
  return hasher.hash();
}

// Header, table and sections to the sink.
Status put_file(const std::vector<Section>& sections, std::uint16_t minor, std::size_t size,
                const Sink& sink) {
  const std::size_t table_size = sections.size() * kEntrySize;
  std::vector<std::byte> front(aligned(kHeaderSize + table_size));
  const std::byte padding[kAlignment] = {};
  std::size_t offset = front.size();
  std::size_t at = kHeaderSize;
  for (const Section& section : sections) {
    Result<std::uint64_t> hash = put_section(section, offset, sink);
    if (!hash) return hash.error();
    put_entry(front, at, section, offset, *hash);
    const std::size_t end = offset + section.size();
    offset = aligned(end);
    if (Status status = sink(end, std::span(padding).first(offset - end)); !status) return status;
    at += kEntrySize;
  }
  std::memcpy(front.data() + header::kMagicAt, kMagic.data(), kMagic.size());
  put(front, header::kMajorAt, kMajor);
  put(front, header::kMinorAt, minor);
  put(front, header::kSectionsAt, static_cast<std::uint32_t>(sections.size()));
  put(front, header::kFileSizeAt, static_cast<std::uint64_t>(size));
  put(front, header::kTableHashAt, hash_bytes(std::span(front).subspan(kHeaderSize, table_size)));
  put(front, header::kHeaderHashAt, hash_bytes(std::span(front).first(header::kHeaderHashAt)));
  return sink(0, front);
}

void use_sources(const RowSources& sources, std::vector<Section>& sections) {
  for (Section& section : sections)
    for (const auto& [name, source] : {std::pair{kSurfaceBasis, &sources.surface},
                                       {kInteriorBasis, &sources.interior},
                                       {kRenderBasis, &sources.render}})
      if (section.name == name) section.source = source;
}

// sources: null when the rows are in `data`. start(size) is told the size of the file and gives the
// sink for it.
Status emit(const BasisData& data, BasisEncoding encoding, const RowSources* sources,
            const std::function<Sink(std::size_t size)>& start) {
  if (Status status = check_shapes(data, sources != nullptr); !status) return status;
  std::optional<CompactArrays> compact;
  if (encoding == BasisEncoding::kCompact) {
    Result<CompactArrays> arrays = make_compact(data);
    if (!arrays) return arrays.error();
    compact = std::move(*arrays);
  }
  const std::uint64_t dimensions[dimension::kCount] = {
      data.vertex_count,
      data.tetrahedron_count,
      data.linear_mode_count,
      static_cast<std::uint64_t>(data.lambda.size()),
      data.fixed_vertex_count,
      data.rigid_mode_count,
      data.surface.vertex_ids.size(),
      data.triangles.size()};
  RenderNames names;
  if (data.render)
    names = {joined(data.render->surface.objects), joined(data.render->surface.materials)};
  std::vector<Section> sections =
      list_sections(data, dimensions, names, compact ? &*compact : nullptr);
  if (sources != nullptr) use_sources(*sources, sections);

  std::size_t size = aligned(kHeaderSize + sections.size() * kEntrySize);
  for (const Section& section : sections) size = aligned(size + section.size());
  const std::uint16_t encoded = compact || is_linear(data) ? kMinorEncoded : kMinor;
  return put_file(sections, data.render ? kMinorRender : encoded, size, start(size));
}

}  // namespace

Result<std::vector<std::byte>> encode_basis(const BasisData& data, BasisEncoding encoding) {
  std::vector<std::byte> file;
  const auto start = [&file](std::size_t size) -> Sink {
    file.resize(size);
    return [&file](std::size_t offset, std::span<const std::byte> bytes) -> Status {
      std::copy(bytes.begin(), bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(offset));
      return Success{};
    };
  };
  if (Status status = emit(data, encoding, nullptr, start); !status) return status.error();
  return file;
}

namespace {

Status write_file(const std::string& path, const BasisData& data, BasisEncoding encoding,
                  const RowSources* sources) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  const auto start = [&file](std::size_t) -> Sink {
    return [&file](std::size_t offset, std::span<const std::byte> bytes) {
      return file->write_at(offset, bytes);
    };
  };
  if (Status status = emit(data, encoding, sources, start); !status) return status;
  return file->commit();
}

}  // namespace

Status write_basis(const std::string& path, const BasisData& data, BasisEncoding encoding) {
  return write_file(path, data, encoding, nullptr);
}

Status write_basis(const std::string& path, const BasisData& data, const RowSources& sources) {
  return write_file(path, data, BasisEncoding::kFull, &sources);
}

}  // namespace tremolo
