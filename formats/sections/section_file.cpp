#include "formats/sections/section_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

using namespace section_layout;

std::string expected_found(const std::string& what, std::uint64_t expected, std::uint64_t found) {
  return what + ": expected " + std::to_string(expected) + ", found " + std::to_string(found);
}

// Without the zero that may be its last character.
std::string magic_text(const FileKind& kind) {
  const std::string_view magic(kind.magic.data(), kind.magic.size());
  return std::string(magic.substr(0, magic.find('\0')));
}

// The kind of a file that Tremolo writes, by its first 8 characters; empty: another file.
std::string_view known_kind(std::span<const std::byte> bytes) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kKinds = {
      {{{"TREMOLO\0", 8}, "a basis file"},
       {"TREMTETS", "a body of tetrahedra, for `kind = \"tets\"` in a scene"},
       {"TREMCOLL", "a collider, for `shape = \"mesh\"` in a scene"},
       {"TREMSAVE", "a saved state, for --restore"},
       {"TREMCKPT", "a checkpoint of tremolo-precompute"}}};
  const std::string_view magic(reinterpret_cast<const char*>(bytes.data()), 8);
  for (const auto& [known, what] : kKinds)
    if (magic == known) return what;
  return {};
}

}  // namespace

Error SectionFile::error_at(std::string_view where, std::uint64_t offset,
                            const std::string& what) const {
  return content_error(name_ + ": " + std::string(where) + " at byte " + std::to_string(offset) +
                       ": " + what);
}

Result<SectionFile> SectionFile::open(const std::string& path, const FileKind& kind) {
  Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  const std::span<const std::byte> bytes = file->bytes();
  Result<SectionFile> opened = from_memory(bytes, path, kind);
  if (opened) opened->file_ = std::move(*file);
  return opened;
}

Result<SectionFile> SectionFile::from_memory(std::span<const std::byte> bytes, std::string name,
                                             const FileKind& kind) {
  SectionFile opened;
  opened.name_ = std::move(name);
  opened.bytes_ = bytes;
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(double) != 0) {
    opened.copy_ = std::make_unique<std::byte[]>(bytes.size());
    std::memcpy(opened.copy_.get(), bytes.data(), bytes.size());
    opened.bytes_ = {opened.copy_.get(), bytes.size()};
  }
  if (Status status = opened.parse_header(kind); !status) return status.error();
  if (Status status = opened.parse_table(); !status) return status.error();
  return opened;
}

Status SectionFile::parse_header(const FileKind& kind) {
  if (bytes_.size() < kHeaderSize)
    return error_at("header", 0,
                    expected_found(std::string(kind.what) + " has a header, bytes", kHeaderSize,
                                   bytes_.size()));
  if (std::memcmp(bytes_.data() + header::kMagicAt, kind.magic.data(), kind.magic.size()) != 0) {
    const std::string_view known = known_kind(bytes_.subspan(header::kMagicAt));
    const std::string why =
        known.empty() ? "(the magic is not " + magic_text(kind) + ")" : "but " + std::string(known);
    return error_at("header", header::kMagicAt, std::string("not ") + kind.what + " " + why);
  }
  const auto hash = get<std::uint64_t>(bytes_, header::kHeaderHashAt);
  if (!hash_fits(bytes_.first(header::kHeaderHashAt), hash))
    return error_at("header", header::kHeaderHashAt, "the checksum does not fit");
  const auto major = get<std::uint16_t>(bytes_, header::kMajorAt);
  if (major != kind.major)
    return error_at("header", header::kMajorAt, expected_found("major version", kind.major, major));
  minor_ = get<std::uint16_t>(bytes_, header::kMinorAt);
  const auto size = get<std::uint64_t>(bytes_, header::kFileSizeAt);
  if (size != bytes_.size())
    return error_at("header", header::kFileSizeAt,
                    expected_found("bytes of the file (truncated?)", size, bytes_.size()));
  const std::size_t reserved = header::kHeaderHashAt - header::kReservedAt;
  if (const auto zeros = leading_zeros(bytes_.subspan(header::kReservedAt, reserved));
      zeros < reserved)
    return error_at("header", header::kReservedAt + zeros, "a reserved byte is not zero");
  return Success{};
}

Status SectionFile::parse_table() {
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

Status SectionFile::parse_entry(std::size_t index) {
  const std::size_t at = kHeaderSize + index * kEntrySize;
  FileSection section;
  section.name = padded_name(bytes_.subspan(at + entry::kNameAt, kNameSize));
  if (section.name.empty())
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

// Sections follow each other in the table's order, with only zeros between them: no overlap, no
// hidden bytes.
Status SectionFile::check_packing() const {
  std::uint64_t end = kHeaderSize + sections_.size() * kEntrySize;
  const auto skip_padding = [&](std::uint64_t to) {
    end += leading_zeros(bytes_.subspan(end, to - end));
    return end == to;
  };
  for (const FileSection& section : sections_) {
    const std::uint64_t start = aligned(end);
    if (section.offset != start)
      return error_at("table", section.offset,
                      "section '" + section.name + "' overlaps or leaves a gap: " +
                          expected_found("offset", start, section.offset));
    if (!skip_padding(start)) return error_at("padding", end, "a byte is not zero");
    end += section.size;
  }
  if (bytes_.size() != aligned(end))
    return error_at("padding", end, "the file does not end behind its last section");
  if (!skip_padding(bytes_.size())) return error_at("padding", end, "a byte is not zero");
  return Success{};
}

Status SectionFile::check_shapes(std::span<const SectionShape> shapes) const {
  const auto refuse = [this](const std::string& what) {
    return error_at("table", kHeaderSize, what);
  };
  for (const SectionShape& shape : shapes) {
    const std::string name(shape.name);
    const FileSection* section = find(name);
    if (section == nullptr) {
      if (shape.critical) return refuse("section '" + name + "' is missing");
      continue;
    }
    if (!shape.needs.empty() && !has(shape.needs))
      return refuse("section '" + name + "' is there, but '" + std::string(shape.needs) +
                    "', which belongs to it, is missing");
    if (section->type != shape.type || section->columns != shape.columns ||
        (shape.rows != kAnyRows && section->rows != shape.rows))
      return error_at(name, section->offset,
                      "type or shape " + std::to_string(section->rows) + " x " +
                          std::to_string(section->columns) + " does not fit the dimensions");
  }
  for (const FileSection& section : sections_)
    if (section.critical && std::none_of(shapes.begin(), shapes.end(), [&](const SectionShape& s) {
          return s.name == section.name;
        }))
      return error_at("table", section.offset,
                      "section '" + section.name + "' is critical and unknown to this version");
  return Success{};
}

const FileSection* SectionFile::find(std::string_view name) const {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const FileSection& s) { return s.name == name; });
  return found == sections_.end() ? nullptr : &*found;
}

Status SectionFile::verify(std::size_t index) {
  if (verified_[index]) return Success{};
  const FileSection& section = sections_[index];
  if (!hash_fits(bytes_.subspan(section.offset, section.size), section.hash))
    return error_at(section.name, section.offset, "the checksum does not fit (damaged file?)");
  verified_[index] = true;
  return Success{};
}

Result<std::span<const std::byte>> SectionFile::contents(std::string_view name, ElementType type) {
  const FileSection* section = find(name);
  if (section == nullptr)
    return error_at("table", kHeaderSize, "section '" + std::string(name) + "' is missing");
  if (section->type != type)
    return error_at(name, section->offset, "the section has another element type");
  if (Status status = verify(section - sections_.data()); !status) return status.error();
  return bytes_.subspan(section->offset, section->size);
}

Status SectionFile::verify_all() {
  for (std::size_t index = 0; index < sections_.size(); ++index)
    if (Status status = verify(index); !status) return status;
  return Success{};
}

template <class T>
Result<std::span<const T>> SectionFile::finite(std::string_view name) {
  Result<std::span<const T>> values = elements<T>(name);
  if (!values) return values;
  for (std::size_t i = 0; i < values->size(); ++i)
    if (!std::isfinite((*values)[i]))
      return error_at(name, find(name)->offset + i * sizeof(T), "a value is not finite");
  return values;
}
template Result<std::span<const double>> SectionFile::finite(std::string_view name);
template Result<std::span<const float>> SectionFile::finite(std::string_view name);

Result<std::string_view> SectionFile::text(std::string_view name) {
  const Result<std::span<const std::uint8_t>> characters = elements<std::uint8_t>(name);
  if (!characters) return characters.error();
  return std::string_view(reinterpret_cast<const char*>(characters->data()), characters->size());
}

}  // namespace tremolo
