#include "formats/basis/basis_writer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "common/hash.h"
#include "formats/basis/basis_sections.h"
#include "formats/basis/compact_values.h"
#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

using namespace basis_layout;
// The bytes of the sections that a file gets. They stay where they are in the caller's data.
using Contents = std::map<std::string_view, std::span<const std::byte>>;

template <class List>
std::span<const std::byte> bytes_of(const List& list) {
  return std::as_bytes(std::span(list.data(), list.size()));
}

// What a file holds beside the caller's own arrays.
struct Additions {
  std::array<std::uint64_t, dimension::kCount> dimensions{};
  std::string objects;  // names, each ended by a zero byte
  std::string materials;
  std::array<double, kRestMoments> rest_moments{};  // of inertia_rest
  std::optional<CompactValues> compact;             // nullopt for a full file
};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(name).push_back('\0');
  return text;
}

bool is_linear(const BasisData& data) {
  return data.cubic.empty() && data.quartic.empty();
}

// Mass, first moment and second moment, row by row.
std::array<double, kRestMoments> rest_moments(const InertiaIntegrals& inertia) {
  std::array<double, kRestMoments> moments{inertia.mass};
  Eigen::Map<Eigen::Vector3d>(moments.data() + 1) = inertia.first_moment;
  Eigen::Map<Eigen::Matrix3d>(moments.data() + 4) = inertia.second_moment;  // symmetric
  return moments;
}

Error does_not_fit(std::string_view what) {
  return content_error("basis data: the size of '" + std::string(what) +
                       "' does not fit the others");
}

// Checks what list_sections() cannot see from the bytes. streamed: the rows come from elsewhere.
Status check_data(const BasisData& data, bool streamed) {
  const Eigen::Index r = data.lambda.size();
  if (r == 0 || std::cmp_greater(r, kMaxModes)) return does_not_fit("lambda");
  if (data.surface.vertex_ids.size() + data.interior.vertex_ids.size() != data.vertex_count ||
      data.vertex_count > kMaxVertices)
    return does_not_fit("vertex_count");
  if (streamed) return Success{};
  for (const auto& [block, name] :
       {std::pair{&data.surface, "surface"}, {&data.interior, "interior"}})
    if (block->rows.rows() != 3 * std::ssize(block->vertex_ids) ||
        (block->rows.rows() > 0 && block->rows.cols() != r))
      return does_not_fit(name);
  if (data.render && !fits(*data.render, r, data.vertex_count)) return does_not_fit("render");
  return Success{};
}

Result<Additions> make_additions(const BasisData& data, BasisEncoding encoding) {
  Additions more;
  more.dimensions[dimension::kVertices] = data.vertex_count;
  more.dimensions[dimension::kTetrahedra] = data.tetrahedron_count;
  more.dimensions[dimension::kLinearModes] = data.linear_mode_count;
  more.dimensions[dimension::kModes] = data.lambda.size();
  more.dimensions[dimension::kFixed] = data.fixed_vertex_count;
  more.dimensions[dimension::kRigid] = data.rigid_mode_count;
  more.dimensions[dimension::kSurfaceVertices] = data.surface.vertex_ids.size();
  more.dimensions[dimension::kTriangles] = data.triangles.size();
  if (data.render) {
    more.objects = joined(data.render->surface.objects);
    more.materials = joined(data.render->surface.materials);
  }
  if (data.inertia) more.rest_moments = rest_moments(*data.inertia);
  if (encoding == BasisEncoding::kFull) return more;
  if (Status status = take(more.compact, compact_values(data)); !status) return status.error();
  return more;
}

void add_render(const RenderBlock& render, const Additions& more, Contents& contents) {
  const RenderSurface& surface = render.surface;
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  static_assert(sizeof(Eigen::Vector2f) == 2 * sizeof(float));
  contents[kRenderRest] = bytes_of(surface.vertices);
  contents[kRenderBasis] = more.compact ? bytes_of(more.compact->render) : bytes_of(render.rows);
  contents[kRenderAnchors] = bytes_of(render.anchors);
  contents[kRenderTriangles] = bytes_of(surface.triangles);
  contents[kRenderObjects] = bytes_of(surface.object_of);
  contents[kRenderMaterials] = bytes_of(surface.material_of);
  contents[kObjectNames] = bytes_of(more.objects);
  contents[kMaterialNames] = bytes_of(more.materials);
  if (!surface.normals.empty()) contents[kRenderNormals] = bytes_of(surface.normals);
  if (!surface.uvs.empty()) contents[kRenderUvs] = bytes_of(surface.uvs);
  if (!surface.colours.empty()) contents[kRenderColours] = bytes_of(surface.colours);
}

Contents contents_of(const BasisData& data, const Additions& more) {
  static_assert(sizeof(VertexId) == 4 && sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  Contents contents = {{kDimensions, bytes_of(more.dimensions)},
                       {kTotalMass, bytes_of(std::span(&data.total_mass, 1))},
                       {kLambda, bytes_of(data.lambda)},
                       {kCubic, bytes_of(data.cubic)},
                       {kQuartic, bytes_of(data.quartic)},
                       {kLoadIds, bytes_of(data.load.vertices)},
                       {kLoadForces, bytes_of(data.load.forces)},
                       {kSurfaceIds, bytes_of(data.surface.vertex_ids)},
                       {kTriangles, bytes_of(data.triangles)},
                       {kSurfaceRest, bytes_of(data.surface.rest)},
                       {kSurfaceBasis, bytes_of(data.surface.rows)},
                       {kInteriorIds, bytes_of(data.interior.vertex_ids)},
                       {kInteriorRest, bytes_of(data.interior.rest)},
                       {kInteriorBasis, bytes_of(data.interior.rows)},
                       {kFixedIds, bytes_of(data.fixed_vertices)},
                       {kSingularValues, bytes_of(data.singular_values)},
                       {kProvenance, bytes_of(data.provenance)}};
  if (const auto& compact = more.compact) {
    contents[kCoefficientScales] = bytes_of(compact->coefficient_scales);
    contents[kBasisScales] = bytes_of(compact->basis_scales);
    contents[kCubic] = bytes_of(compact->cubic);
    contents[kQuartic] = bytes_of(compact->quartic);
    contents[kSurfaceBasis] = bytes_of(compact->surface);
    contents[kInteriorBasis] = bytes_of(compact->interior);
  }
  static_assert(sizeof(MeshEdge) == 3 * sizeof(VertexId));
  if (!data.edges.empty()) contents[kEdgePoints] = bytes_of(data.edges);
  if (data.render) add_render(*data.render, more, contents);
  if (data.inertia) {
    contents[kInertiaRest] = bytes_of(more.rest_moments);
    contents[kInertiaLinear] = bytes_of(data.inertia->linear);
    contents[kInertiaPairs] = bytes_of(data.inertia->B);
  }
  if (!data.vega.basis.empty()) contents[kVegaBasis] = bytes_of(data.vega.basis);
  if (!data.vega.cubic.empty()) contents[kVegaCubic] = bytes_of(data.vega.cubic);
  return contents;
}

// A section to come: its bytes, or where its rows come from.
struct Section {
  SectionShape shape;
  std::span<const std::byte> bytes;
  const RowSource* source;

  std::size_t row_size() const { return shape.columns * element_size(shape.type); }
  std::size_t size() const { return shape.rows * row_size(); }
};

const RowSource* source_of(std::string_view name, const RowSources* sources) {
  if (sources == nullptr) return nullptr;
  return name == kSurfaceBasis    ? &sources->surface
         : name == kInteriorBasis ? &sources->interior
         : name == kRenderBasis   ? &sources->render
                                  : nullptr;
}

Result<std::vector<Section>> list_sections(const BasisData& data, const Additions& more,
                                           const RowSources* sources) {
  const RenderSurface* render = data.render ? &data.render->surface : nullptr;
  const SectionSizes sizes = {.modes = more.dimensions[dimension::kModes],
                              .surface_vertices = data.surface.vertex_ids.size(),
                              .interior_vertices = data.interior.vertex_ids.size(),
                              .triangles = data.triangles.size(),
                              .fixed = data.fixed_vertex_count,
                              .loaded = data.load.vertices.size(),
                              .render_vertices = render ? render->vertices.size() : 0,
                              .render_triangles = render ? render->triangles.size() : 0,
                              .edges = data.edges.size(),
                              .compact = more.compact.has_value(),
                              .linear = is_linear(data)};
  const Contents contents = contents_of(data, more);
  std::vector<Section> sections;
  for (const SectionShape& shape : section_shapes(sizes)) {
    const auto found = contents.find(shape.name);
    if (found == contents.end()) continue;
    Section section{shape, found->second, source_of(shape.name, sources)};
    if (shape.rows == kAnyRows) section.shape.rows = section.bytes.size() / section.row_size();
    if (section.source == nullptr && section.bytes.size() != section.size())
      return does_not_fit(shape.name);
    sections.push_back(section);
  }
  return sections;
}

void put_entry(std::span<std::byte> table, std::size_t at, const Section& section,
               std::size_t offset, std::uint64_t hash) {
  const SectionShape& shape = section.shape;
  std::memcpy(table.data() + at + entry::kNameAt, shape.name.data(), shape.name.size());
  put<std::uint32_t>(table, at + entry::kTypeAt, static_cast<std::uint32_t>(shape.type));
  put<std::uint32_t>(table, at + entry::kFlagsAt, shape.critical ? kCritical : 0);
  put<std::uint64_t>(table, at + entry::kOffsetAt, offset);
  put<std::uint64_t>(table, at + entry::kSizeAt, section.size());
  put<std::uint64_t>(table, at + entry::kRowsAt, shape.rows);
  put<std::uint64_t>(table, at + entry::kColumnsAt, shape.columns);
  put<std::uint64_t>(table, at + entry::kHashAt, hash);
}

// Takes bytes for a place of the file, in ascending order but for the header, which comes last.
using Sink = std::function<Status(std::size_t offset, std::span<const std::byte> bytes)>;

// The section's bytes to the sink; their hash.
Result<std::uint64_t> put_section(const Section& section, std::size_t offset, const Sink& sink) {
  if (section.source == nullptr) {
    if (Status status = sink(offset, section.bytes); !status) return status.error();
    return hash_bytes(section.bytes);
  }
  const std::size_t vertices = section.shape.rows / 3;
  const std::size_t numbers = 3 * section.shape.columns;
  std::vector<double> rows(std::min(vertices, kRowsAtOnce) * numbers);
  Hasher hasher;
  for (std::size_t first = 0; first < vertices; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, vertices - first);
    if (Status status = (*section.source)(first, count, rows.data()); !status)
      return status.error();
    const std::span<const std::byte> bytes = bytes_of(std::span(rows).first(count * numbers));
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
  put<std::uint16_t>(front, header::kMajorAt, kMajor);
  put<std::uint16_t>(front, header::kMinorAt, minor);
  put<std::uint32_t>(front, header::kSectionsAt, static_cast<std::uint32_t>(sections.size()));
  put<std::uint64_t>(front, header::kFileSizeAt, size);
  put<std::uint64_t>(front, header::kTableHashAt,
                     hash_bytes(std::span(front).subspan(kHeaderSize, table_size)));
  put<std::uint64_t>(front, header::kHeaderHashAt,
                     hash_bytes(std::span(front).first(header::kHeaderHashAt)));
  return sink(0, front);
}

// sources: null when the rows are in `data`. start(size) is told the size of the file and gives the
// sink for it.
Status emit(const BasisData& data, BasisEncoding encoding, const RowSources* sources,
            const std::function<Sink(std::size_t size)>& start) {
  if (Status status = check_data(data, sources != nullptr); !status) return status;
  const Result<Additions> more = make_additions(data, encoding);
  if (!more) return more.error();
  const Result<std::vector<Section>> sections = list_sections(data, *more, sources);
  if (!sections) return sections.error();
  std::size_t size = aligned(kHeaderSize + sections->size() * kEntrySize);
  for (const Section& section : *sections) size = aligned(size + section.size());
  const std::uint16_t encoded = more->compact || is_linear(data) ? kMinorEncoded : kMinor;
  const std::uint16_t shown = data.render ? kMinorRender : encoded;
  return put_file(*sections, data.edges.empty() ? shown : kMinorQuadratic, size, start(size));
}

}  // namespace

Result<std::vector<std::byte>> encode_basis(const BasisData& data, BasisEncoding encoding) {
  std::vector<std::byte> file;
  const auto start = [&file](std::size_t size) -> Sink {
    file.resize(size);
    return [&file](std::size_t offset, std::span<const std::byte> bytes) -> Status {
      std::copy(bytes.begin(), bytes.end(), file.begin() + offset);
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
