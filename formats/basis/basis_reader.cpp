#include "formats/basis/basis_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "common/packed_index.h"
#include "formats/basis/compact_values.h"
#include "formats/file/stored_hash.h"

namespace tremolo {
namespace {

using namespace basis_layout;

template <class T>
T get(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

std::string expected_found(const char* what, std::uint64_t expected, std::uint64_t found) {
  return std::string(what) + ": expected " + std::to_string(expected) + ", found " +
         std::to_string(found);
}

}  // namespace

Error BasisReader::error_at(std::string_view where, std::uint64_t offset,
                            const std::string& what) const {
  return content_error(name_ + ": " + std::string(where) + " at byte " + std::to_string(offset) +
                       ": " + what);
}

Result<BasisReader> BasisReader::open(const std::string& path) {
  Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  const std::span<const std::byte> bytes = file->bytes();
  Result<BasisReader> reader = from_memory(bytes, path);
  if (reader) reader->file_ = std::move(*file);
  return reader;
}

Result<BasisReader> BasisReader::from_memory(std::span<const std::byte> bytes, std::string name) {
  BasisReader reader;
  reader.name_ = std::move(name);
  reader.bytes_ = bytes;
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(double) != 0) {
    reader.copy_ = std::make_unique_for_overwrite<std::byte[]>(bytes.size());
    std::memcpy(reader.copy_.get(), bytes.data(), bytes.size());
    reader.bytes_ = {reader.copy_.get(), bytes.size()};
  }
  if (Status status = reader.parse_header(); !status) return status.error();
  if (Status status = reader.parse_table(); !status) return status.error();
  if (Status status = reader.read_dimensions(); !status) return status.error();
  if (Status status = reader.check_shapes(); !status) return status.error();
  return reader;
}

Status BasisReader::parse_header() {
  if (bytes_.size() < kHeaderSize)
    return error_at("header", 0,
                    expected_found("a basis file has a header, bytes", kHeaderSize, bytes_.size()));
  if (std::memcmp(bytes_.data() + header::kMagicAt, kMagic.data(), kMagic.size()) != 0)
    return error_at("header", header::kMagicAt, "not a basis file (the magic is not TREMOLO)");
  const auto hash = get<std::uint64_t>(bytes_, header::kHeaderHashAt);
  if (!hash_fits(bytes_.first(header::kHeaderHashAt), hash))
    return error_at("header", header::kHeaderHashAt, "the checksum does not fit");
  const auto major = get<std::uint16_t>(bytes_, header::kMajorAt);
  if (major != kMajor)
    return error_at("header", header::kMajorAt, expected_found("major version", kMajor, major));
  minor_ = get<std::uint16_t>(bytes_, header::kMinorAt);
  const auto size = get<std::uint64_t>(bytes_, header::kFileSizeAt);
  if (size != bytes_.size())
    return error_at("header", header::kFileSizeAt,
                    expected_found("bytes of the file (truncated?)", size, bytes_.size()));
  for (std::size_t at = header::kReservedAt; at < header::kHeaderHashAt; ++at)
    if (bytes_[at] != std::byte{0}) return error_at("header", at, "a reserved byte is not zero");
  return Success{};
}

Status BasisReader::parse_table() {
  const auto count = get<std::uint32_t>(bytes_, header::kSectionsAt);
  if (count == 0 || count > kMaxSections || kHeaderSize + count * kEntrySize > bytes_.size())
    return error_at("header", header::kSectionsAt,
                    std::to_string(count) + " sections do not fit the file");
  const auto table = bytes_.subspan(kHeaderSize, count * kEntrySize);
  if (!hash_fits(table, get<std::uint64_t>(bytes_, header::kTableHashAt)))
    return error_at("table", kHeaderSize, "the checksum does not fit");
  sections_.reserve(count);
  for (std::uint32_t index = 0; index < count; ++index)
    if (Status status = parse_entry(index); !status) return status;
  verified_.assign(count, false);
  return check_packing();
}

Status BasisReader::parse_entry(std::size_t index) {
  const std::size_t at = kHeaderSize + index * kEntrySize;
  const char* name = reinterpret_cast<const char*>(bytes_.data() + at + entry::kNameAt);
  const std::size_t length = ::strnlen(name, kNameSize);
  BasisSection section;
  section.name.assign(name, length);
  if (length == 0 || std::any_of(name + length, name + kNameSize, [](char c) { return c != 0; }))
    return error_at("table", at, "a section name is empty or not padded with zeros");
  if (find(section.name) != nullptr)
    return error_at("table", at, "section '" + section.name + "' appears twice");
  const auto flags = get<std::uint32_t>(bytes_, at + entry::kFlagsAt);
  if ((flags & ~kCritical) != 0) return error_at("table", at, "unknown flags");
  section.critical = (flags & kCritical) != 0;
  section.type = static_cast<ElementType>(get<std::uint32_t>(bytes_, at + entry::kTypeAt));
  section.offset = get<std::uint64_t>(bytes_, at + entry::kOffsetAt);
  section.size = get<std::uint64_t>(bytes_, at + entry::kSizeAt);
  section.rows = get<std::uint64_t>(bytes_, at + entry::kRowsAt);
  section.columns = get<std::uint64_t>(bytes_, at + entry::kColumnsAt);
  section.hash = get<std::uint64_t>(bytes_, at + entry::kHashAt);

  const std::uint64_t element = element_size(section.type);
  if (element == 0) return error_at("table", at + entry::kTypeAt, "unknown element type");
  std::uint64_t expected = 0;
  if (__builtin_mul_overflow(section.rows, section.columns, &expected) ||
      __builtin_mul_overflow(expected, element, &expected) || expected != section.size)
    return error_at("table", at + entry::kSizeAt,
                    "the size of section '" + section.name + "' is not rows x columns x element");
  if (section.offset > bytes_.size() || section.size > bytes_.size() - section.offset)
    return error_at("table", at + entry::kOffsetAt,
                    "section '" + section.name + "' is not inside the file");
  sections_.push_back(std::move(section));
  return Success{};
}

// Sections follow each other in the table's order with nothing but zeros between: no overlap, no
// hidden bytes.
Status BasisReader::check_packing() const {
  std::uint64_t end = kHeaderSize + sections_.size() * kEntrySize;
  const auto skip_padding = [&](std::uint64_t to) {
    while (end < to && bytes_[end] == std::byte{0}) ++end;
    return end == to;
  };
  for (const BasisSection& section : sections_) {
    const std::uint64_t start = (end + kAlignment - 1) / kAlignment * kAlignment;
    if (section.offset != start)
      return error_at("table", section.offset,
                      "section '" + section.name + "' overlaps or leaves a gap: " +
                          expected_found("offset", start, section.offset));
    if (!skip_padding(start)) return error_at("padding", end, "a byte is not zero");
    end += section.size;
  }
  if (bytes_.size() != (end + kAlignment - 1) / kAlignment * kAlignment)
    return error_at("padding", end, "the file does not end behind its last section");
  if (!skip_padding(bytes_.size())) return error_at("padding", end, "a byte is not zero");
  return Success{};
}

Status BasisReader::read_dimensions() {
  const BasisSection* section = find(kDimensions);
  if (section == nullptr || section->rows != dimension::kCount || section->columns != 1)
    return error_at("table", kHeaderSize, "section 'dimensions' is missing or has another shape");
  Result<std::span<const std::byte>> bytes = contents(kDimensions, ElementType::kU64);
  if (!bytes) return bytes.error();
  std::uint64_t v[dimension::kCount];
  std::memcpy(v, bytes->data(), sizeof(v));
  dimensions_ = {v[dimension::kVertices],        v[dimension::kTetrahedra],
                 v[dimension::kLinearModes],     v[dimension::kModes],
                 v[dimension::kFixed],           v[dimension::kRigid],
                 v[dimension::kSurfaceVertices], v[dimension::kTriangles]};
  const BasisDimensions& d = dimensions_;
  if (d.modes == 0 || d.modes > kMaxModes || d.vertices == 0 || d.vertices > kMaxVertices ||
      d.surface_vertices > d.vertices || d.fixed > d.vertices || d.triangles > 4 * kMaxVertices)
    return error_at(kDimensions, section->offset, "the dimensions are out of range");
  return Success{};
}

Status BasisReader::check_shapes() const {
  const BasisDimensions& d = dimensions_;
  const std::uint64_t inner = d.vertices - d.surface_vertices;
  struct Shape {
    std::string_view name;
    ElementType type;
    std::uint64_t rows, columns;
    bool required;
  };
  constexpr std::uint64_t kAnyRows = ~std::uint64_t{0};
  const BasisSection* render = find(kRenderRest);
  const std::uint64_t shown = render != nullptr ? render->rows : 0;
  const BasisSection* corners = find(kRenderTriangles);
  const std::uint64_t faces = corners != nullptr ? corners->rows : 0;
  if (shown > kMaxVertices || faces > 4 * kMaxVertices)
    return error_at("table", kHeaderSize, "the render surface is too large");
  const BasisSection* quartic = find(kQuartic);
  const bool no_terms = quartic != nullptr && quartic->rows == 0;
  const ElementType coefficient = compact() ? ElementType::kF32 : ElementType::kF64;
  const ElementType basis = compact() ? ElementType::kI16 : ElementType::kF64;
  const Shape shapes[] = {
      {kDimensions, ElementType::kU64, dimension::kCount, 1, true},
      {kTotalMass, ElementType::kF64, 1, 1, false},
      {kLambda, ElementType::kF64, d.modes, 1, true},
      {kCoefficientScales, ElementType::kF64, coefficient_scale::kCount, 1, compact()},
      {kBasisScales, ElementType::kF64, d.modes, 1, false},
      {kCubic, coefficient, no_terms ? 0 : triple_count(d.modes), 1, true},
      {kQuartic, coefficient, no_terms ? 0 : quad_count(d.modes), 1, true},
      {kSurfaceIds, ElementType::kU32, d.surface_vertices, 1, true},
      {kSurfaceRest, ElementType::kF64, d.surface_vertices, 3, true},
      {kSurfaceBasis, basis, 3 * d.surface_vertices, d.modes, true},
      {kTriangles, ElementType::kU32, d.triangles, 3, true},
      {kRenderRest, ElementType::kF64, shown, 3, false},
      {kRenderBasis, basis, 3 * shown, d.modes, false},
      {kRenderAnchors, ElementType::kU32, shown, 1, false},
      {kRenderTriangles, ElementType::kU32, faces, 3, false},
      {kRenderObjects, ElementType::kU32, faces, 1, false},
      {kRenderMaterials, ElementType::kU32, faces, 1, false},
      {kObjectNames, ElementType::kU8, kAnyRows, 1, false},
      {kMaterialNames, ElementType::kU8, kAnyRows, 1, false},
      {kRenderNormals, ElementType::kF32, shown, 3, false},
      {kRenderUvs, ElementType::kF32, shown, 2, false},
      {kRenderColours, ElementType::kU8, shown, 4, false},
      {kInteriorIds, ElementType::kU32, inner, 1, false},
      {kInteriorRest, ElementType::kF64, inner, 3, false},
      {kInteriorBasis, basis, 3 * inner, d.modes, false},
      {kFixedIds, ElementType::kU32, d.fixed, 1, false},
      {kLoadIds, ElementType::kU32, kAnyRows, 1, false},
      {kLoadForces, ElementType::kF64, kAnyRows, 3, false},
      {kSingularValues, ElementType::kF64, kAnyRows, 1, false},
      {kProvenance, ElementType::kU8, kAnyRows, 1, false},
      {kVegaBasis, ElementType::kU8, kAnyRows, 1, false},
      {kVegaCubic, ElementType::kU8, kAnyRows, 1, false},
  };
  for (const Shape& shape : shapes) {
    const BasisSection* section = find(shape.name);
    if (section == nullptr) {
      if (!shape.required) continue;
      return error_at("table", kHeaderSize, "section '" + std::string(shape.name) + "' is missing");
    }
    if (section->type != shape.type || section->columns != shape.columns ||
        (shape.rows != kAnyRows && section->rows != shape.rows))
      return error_at(shape.name, section->offset,
                      "type or shape " + std::to_string(section->rows) + " x " +
                          std::to_string(section->columns) + " does not fit the dimensions");
  }
  for (const BasisSection& section : sections_)
    if (section.critical && std::none_of(std::begin(shapes), std::end(shapes),
                                         [&](const Shape& s) { return s.name == section.name; }))
      return error_at("table", section.offset,
                      "section '" + section.name + "' is critical and unknown to this version");
  if (has(kCoefficientScales) && !compact())
    return error_at("table", kHeaderSize, "section 'basis_scales' is missing");
  const BasisSection* ids = find(kLoadIds);
  const BasisSection* forces = find(kLoadForces);
  if ((ids == nullptr) != (forces == nullptr) || (ids != nullptr && ids->rows != forces->rows))
    return error_at("table", kHeaderSize, "sections 'load_ids' and 'load_forces' do not fit");
  return check_render();
}

Status BasisReader::check_render() const {
  constexpr std::string_view kNeeded[] = {kRenderRest,      kRenderBasis,   kRenderAnchors,
                                          kRenderTriangles, kRenderObjects, kRenderMaterials,
                                          kObjectNames,     kMaterialNames};
  constexpr std::string_view kAdded[] = {kRenderNormals, kRenderUvs, kRenderColours};
  const auto there = [this](std::string_view name) { return has(name); };
  if (std::all_of(std::begin(kNeeded), std::end(kNeeded), there)) {
    if (find(kRenderRest)->rows > 0) return Success{};
    return error_at(kRenderRest, find(kRenderRest)->offset, "a render surface without vertices");
  }
  for (const auto& names : {std::span<const std::string_view>(kNeeded), {kAdded}})
    for (const std::string_view name : names)
      if (has(name))
        return error_at("table", kHeaderSize,
                        "section '" + std::string(name) +
                            "' is there, but not all sections of a render surface are");
  return Success{};
}

const BasisSection* BasisReader::find(std::string_view name) const {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const BasisSection& s) { return s.name == name; });
  return found == sections_.end() ? nullptr : &*found;
}

Status BasisReader::verify(std::size_t index) {
  if (verified_[index]) return Success{};
  const BasisSection& section = sections_[index];
  if (!hash_fits(bytes_.subspan(section.offset, section.size), section.hash))
    return error_at(section.name, section.offset, "the checksum does not fit (damaged file?)");
  verified_[index] = true;
  return Success{};
}

Result<std::span<const std::byte>> BasisReader::contents(std::string_view name, ElementType type) {
  const BasisSection* section = find(name);
  if (section == nullptr)
    return error_at("table", kHeaderSize, "section '" + std::string(name) + "' is missing");
  if (section->type != type)
    return error_at(name, section->offset, "the section has another element type");
  const auto index = static_cast<std::size_t>(section - sections_.data());
  if (Status status = verify(index); !status) return status.error();
  return bytes_.subspan(section->offset, section->size);
}

Result<std::span<const double>> BasisReader::doubles(std::string_view name) {
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kF64);
  if (!bytes) return bytes.error();
  const std::span<const double> values{reinterpret_cast<const double*>(bytes->data()),
                                       bytes->size() / sizeof(double)};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      return error_at(name, find(name)->offset + i * sizeof(double), "a value is not finite");
  return values;
}

Result<std::span<const double>> BasisReader::scales(std::string_view name) {
  Result<std::span<const double>> values = doubles(name);
  if (!values) return values.error();
  for (std::size_t i = 0; i < values->size(); ++i)
    if (!is_scale((*values)[i]))
      return error_at(name, find(name)->offset + i * sizeof(double),
                      "a scale is not positive or too large");
  return values;
}

Result<std::vector<double>> BasisReader::coefficients(std::string_view name) {
  if (!compact()) {
    Result<std::span<const double>> values = doubles(name);
    if (!values) return values.error();
    return std::vector<double>(values->begin(), values->end());
  }
  Result<std::span<const double>> both = scales(kCoefficientScales);
  if (!both) return both.error();
  const double scale =
      (*both)[name == kCubic ? coefficient_scale::kCubic : coefficient_scale::kQuartic];
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kF32);
  if (!bytes) return bytes.error();
  std::vector<double> values(bytes->size() / sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = scale * static_cast<double>(get<float>(*bytes, i * sizeof(float)));
    if (!std::isfinite(values[i]))
      return error_at(name, find(name)->offset + i * sizeof(float), "a value is not finite");
  }
  return values;
}

Result<BasisRows> BasisReader::basis_rows(std::string_view name) {
  const auto columns = static_cast<Eigen::Index>(dimensions_.modes);
  if (!compact()) {
    Result<std::span<const double>> values = doubles(name);
    if (!values) return values.error();
    const auto rows = static_cast<Eigen::Index>(values->size()) / columns;
    return BasisRows(Eigen::Map<const BasisRows>(values->data(), rows, columns));
  }
  Result<std::span<const double>> column_scale = scales(kBasisScales);
  if (!column_scale) return column_scale.error();
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kI16);
  if (!bytes) return bytes.error();
  const auto count = static_cast<Eigen::Index>(bytes->size() / sizeof(std::int16_t));
  BasisRows rows(count / columns, columns);
  const auto* integers = reinterpret_cast<const std::int16_t*>(bytes->data());
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < columns; ++i)
      rows(row, i) =
          (*column_scale)[static_cast<std::size_t>(i)] * static_cast<double>(*integers++);
  return rows;
}

Result<std::span<const std::uint32_t>> BasisReader::indices(std::string_view name,
                                                            std::uint64_t bound) {
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kU32);
  if (!bytes) return bytes.error();
  const std::span<const std::uint32_t> values{reinterpret_cast<const std::uint32_t*>(bytes->data()),
                                              bytes->size() / sizeof(std::uint32_t)};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] >= bound)
      return error_at(
          name, find(name)->offset + i * sizeof(std::uint32_t),
          "index " + std::to_string(values[i]) + " is not below " + std::to_string(bound));
  return values;
}

Result<std::string_view> BasisReader::text(std::string_view name) {
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kU8);
  if (!bytes) return bytes.error();
  return std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

Result<std::span<const float>> BasisReader::floats(std::string_view name) {
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kF32);
  if (!bytes) return bytes.error();
  const std::span<const float> values{reinterpret_cast<const float*>(bytes->data()),
                                      bytes->size() / sizeof(float)};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      return error_at(name, find(name)->offset + i * sizeof(float), "a value is not finite");
  return values;
}

Result<std::span<const std::uint8_t>> BasisReader::bytes(std::string_view name) {
  Result<std::span<const std::byte>> bytes = contents(name, ElementType::kU8);
  if (!bytes) return bytes.error();
  return std::span<const std::uint8_t>{reinterpret_cast<const std::uint8_t*>(bytes->data()),
                                       bytes->size()};
}

Result<Eigen::VectorXd> BasisReader::column_scales() {
  if (!compact()) return Eigen::VectorXd();
  const Result<std::span<const double>> columns = scales(kBasisScales);
  if (!columns) return columns.error();
  return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(
      columns->data(), static_cast<Eigen::Index>(columns->size())));
}

Result<VertexBlock> BasisReader::vertex_block(std::string_view ids, std::string_view rest,
                                              std::string_view basis) {
  Result<std::span<const std::uint32_t>> id_values = indices(ids, dimensions_.vertices);
  if (!id_values) return id_values.error();
  for (std::size_t i = 1; i < id_values->size(); ++i)
    if ((*id_values)[i - 1] >= (*id_values)[i])
      return error_at(ids, find(ids)->offset + 4 * i, "the ids do not ascend");
  Result<std::span<const double>> positions = doubles(rest);
  if (!positions) return positions.error();
  Result<BasisRows> rows = basis_rows(basis);
  if (!rows) return rows.error();
  VertexBlock block;
  block.vertex_ids.assign(id_values->begin(), id_values->end());
  block.rest.resize(block.vertex_ids.size());
  for (std::size_t v = 0; v < block.rest.size(); ++v)
    block.rest[v] = Eigen::Map<const Eigen::Vector3d>(positions->data() + 3 * v);
  block.rows = std::move(*rows);
  Result<Eigen::VectorXd> columns = column_scales();
  if (!columns) return columns.error();
  block.column_scales = std::move(*columns);
  return block;
}

Status BasisReader::verify_all() {
  for (std::size_t index = 0; index < sections_.size(); ++index)
    if (Status status = verify(index); !status) return status;
  return Success{};
}

}  // namespace tremolo
