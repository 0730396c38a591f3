#include "formats/file/checkpoint_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

namespace layout = checkpoint_layout;

// 0: unknown.
std::uint64_t element_size(ArrayType type) {
  switch (type) {
    case ArrayType::kF64:
    case ArrayType::kI64:
      return 8;
    case ArrayType::kText:
      return 1;
  }
  return 0;
}

// Returns whether the shape of an array is valid, and its size. An empty array has one column:
// otherwise 0 times any number would be valid, and a loop over its columns would not end.
bool find_size(ArrayType type, std::uint64_t rows, std::uint64_t columns, std::uint64_t& bytes) {
  const std::uint64_t element = element_size(type);
  if (element == 0 || __builtin_mul_overflow(rows, columns, &bytes) ||
      __builtin_mul_overflow(bytes, element, &bytes))
    return false;
  return columns == 1 || (type != ArrayType::kText && bytes > 0);
}

Status check_arrays(const std::string& path, std::span<const NamedArray> arrays) {
  const auto bad = [&path](const NamedArray& array, const char* what) {
    return content_error(path + ": array '" + array.name + "': " + what);
  };
  if (arrays.empty() || arrays.size() > layout::kMaxArrays)
    return content_error(path + ": no arrays, or too many");
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const NamedArray& array = arrays[i];
    if (array.name.empty() || array.name.size() > layout::kNameSize ||
        array.name.find('\0') != std::string::npos)
      return bad(array, "no name for an array");
    for (std::size_t other = 0; other < i; ++other)
      if (arrays[other].name == array.name) return bad(array, "appears twice");
    std::uint64_t bytes = 0;
    if (!find_size(array.type, array.rows, array.columns, bytes) || bytes != array.bytes.size())
      return bad(array, "the size does not fit the bytes");
  }
  return Success{};
}

// Header and table.
std::vector<std::byte> encode_front(std::span<const NamedArray> arrays) {
  std::vector<std::byte> front(layout::kHeaderSize + arrays.size() * layout::kEntrySize);
  const std::span<std::byte> header = std::span(front).first(layout::kHeaderSize);
  const std::span<std::byte> table = std::span(front).subspan(layout::kHeaderSize);
  std::uint64_t size = front.size();
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const std::span<std::byte> entry = table.subspan(i * layout::kEntrySize, layout::kEntrySize);
    std::memcpy(entry.data(), arrays[i].name.data(), arrays[i].name.size());
    put(entry, layout::kTypeAt, arrays[i].type);
    put(entry, layout::kRowsAt, arrays[i].rows);
    put(entry, layout::kColumnsAt, arrays[i].columns);
    put(entry, layout::kHashAt, hash_bytes(arrays[i].bytes));
    size += arrays[i].bytes.size();
  }
  std::memcpy(header.data(), layout::kMagic.data(), layout::kMagic.size());
  put(header, layout::kVersionAt, layout::kVersion);
  put(header, layout::kArraysAt, static_cast<std::uint32_t>(arrays.size()));
  put(header, layout::kFileSizeAt, size);
  put(header, layout::kTableHashAt, hash_bytes(table));
  put(header, layout::kHeaderHashAt, hash_bytes(header.first(layout::kHeaderHashAt)));
  return front;
}

}  // namespace

NamedArray named_array(std::string name, std::span<const double> values, std::uint64_t rows,
                       std::uint64_t columns) {
  return {std::move(name), ArrayType::kF64, rows, columns, std::as_bytes(values)};
}

NamedArray named_array(std::string name, std::span<const std::int64_t> values) {
  return {std::move(name), ArrayType::kI64, values.size(), 1, std::as_bytes(values)};
}

NamedArray named_array(std::string name, std::string_view text) {
  return {std::move(name), ArrayType::kText, text.size(), 1,
          std::as_bytes(std::span(text.data(), text.size()))};
}

Status write_checkpoint_file(const std::string& path, std::span<const NamedArray> arrays) {
  if (Status status = check_arrays(path, arrays); !status) return status;
  const std::vector<std::byte> front = encode_front(arrays);
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Status status = file->write(front); !status) return status;
  for (const NamedArray& array : arrays)
    if (Status status = file->write(array.bytes); !status) return status;
  return file->commit();
}

Error CheckpointFile::error_at(std::string_view where, std::uint64_t offset,
                               const std::string& what) const {
  return content_error(name_ + ": " + std::string(where) + " at byte " + std::to_string(offset) +
                       ": " + what);
}

Result<CheckpointFile> CheckpointFile::open(const std::string& path) {
  Result<MappedFile> mapped = MappedFile::open(path);
  if (!mapped) return mapped.error();
  Result<CheckpointFile> file = from_memory(mapped->bytes(), path);
  if (file) file->file_ = std::move(*mapped);
  return file;
}

Result<CheckpointFile> CheckpointFile::from_memory(std::span<const std::byte> bytes,
                                                   std::string name) {
  CheckpointFile file;
  file.name_ = std::move(name);
  file.bytes_ = bytes;
  if (Status status = file.parse_header(); !status) return status.error();
  if (Status status = file.parse_table(); !status) return status.error();
  return file;
}

Status CheckpointFile::parse_header() {
  if (bytes_.size() < layout::kHeaderSize)
    return error_at("header", 0,
                    std::to_string(bytes_.size()) + " bytes are no checkpoint: it was cut off");
  if (std::memcmp(bytes_.data(), layout::kMagic.data(), layout::kMagic.size()) != 0)
    return error_at("header", 0, "not a checkpoint (the magic is not TREMCKPT)");
  if (!hash_fits(bytes_.first(layout::kHeaderHashAt),
                 get<std::uint64_t>(bytes_, layout::kHeaderHashAt)))
    return error_at("header", layout::kHeaderHashAt, "the checksum does not fit");
  if (const auto version = get<std::uint32_t>(bytes_, layout::kVersionAt);
      version != layout::kVersion)
    return error_at("header", layout::kVersionAt,
                    "version " + std::to_string(version) + ", this program writes " +
                        std::to_string(layout::kVersion));
  if (const auto size = get<std::uint64_t>(bytes_, layout::kFileSizeAt); size != bytes_.size())
    return error_at(
        "header", layout::kFileSizeAt,
        std::to_string(size) + " bytes were written, there are " + std::to_string(bytes_.size()));
  const std::size_t reserved = layout::kHeaderHashAt - layout::kReservedAt;
  if (const auto zeros = leading_zeros(bytes_.subspan(layout::kReservedAt, reserved));
      zeros < reserved)
    return error_at("header", layout::kReservedAt + zeros, "a reserved byte is not zero");
  return Success{};
}

Status CheckpointFile::parse_table() {
  const auto count = get<std::uint32_t>(bytes_, layout::kArraysAt);
  if (count == 0 || count > layout::kMaxArrays ||
      layout::kHeaderSize + count * layout::kEntrySize > bytes_.size())
    return error_at("header", layout::kArraysAt,
                    std::to_string(count) + " arrays do not fit the file");
  if (!hash_fits(bytes_.subspan(layout::kHeaderSize, count * layout::kEntrySize),
                 get<std::uint64_t>(bytes_, layout::kTableHashAt)))
    return error_at("table", layout::kHeaderSize, "the checksum does not fit");
  std::uint64_t offset = layout::kHeaderSize + count * layout::kEntrySize;
  for (std::size_t index = 0; index < count; ++index)
    if (Status status = parse_entry(index, offset); !status) return status;
  if (offset != bytes_.size())
    return error_at("table", layout::kHeaderSize,
                    "the arrays end at byte " + std::to_string(offset) + ", the file does not");
  return Success{};
}

// offset: where this array begins; afterwards, where the next one does.
Status CheckpointFile::parse_entry(std::size_t index, std::uint64_t& offset) {
  const std::size_t at = layout::kHeaderSize + index * layout::kEntrySize;
  const std::span<const std::byte> entry = bytes_.subspan(at, layout::kEntrySize);
  NamedArray array;
  array.name = padded_name(entry.first(layout::kNameSize));
  if (array.name.empty()) return error_at("table", at, "a name is empty or not padded with zeros");
  for (const NamedArray& other : arrays_)
    if (other.name == array.name)
      return error_at("table", at, "array '" + array.name + "' appears twice");
  if (get<std::uint32_t>(entry, layout::kZeroAt) != 0)
    return error_at("table", at + layout::kZeroAt, "a reserved byte is not zero");
  array.type = get<ArrayType>(entry, layout::kTypeAt);
  array.rows = get<std::uint64_t>(entry, layout::kRowsAt);
  array.columns = get<std::uint64_t>(entry, layout::kColumnsAt);
  std::uint64_t size = 0;
  if (!find_size(array.type, array.rows, array.columns, size))
    return error_at("table", at + layout::kTypeAt,
                    "array '" + array.name + "' has no possible size");
  if (size > bytes_.size() - offset)
    return error_at("table", at + layout::kRowsAt,
                    "array '" + array.name + "' is not inside the file");
  array.bytes = bytes_.subspan(offset, size);
  offset += size;
  arrays_.push_back(std::move(array));
  hashes_.push_back(get<std::uint64_t>(entry, layout::kHashAt));
  return Success{};
}

std::uint64_t CheckpointFile::offset_of(const NamedArray& array) const {
  return array.bytes.data() - bytes_.data();
}

Result<NamedArray> CheckpointFile::checked(std::string_view name, ArrayType type) const {
  const auto found = std::find_if(arrays_.begin(), arrays_.end(),
                                  [&](const NamedArray& array) { return array.name == name; });
  if (found == arrays_.end())
    return error_at("table", layout::kHeaderSize, "array '" + std::string(name) + "' is missing");
  if (found->type != type) return error_at(name, offset_of(*found), "the array has another type");
  if (!hash_fits(found->bytes, hashes_[found - arrays_.begin()]))
    return error_at(name, offset_of(*found), "the checksum does not fit (damaged file?)");
  return *found;
}

Result<Eigen::MatrixXd> CheckpointFile::matrix(std::string_view name) const {
  const Result<NamedArray> array = checked(name, ArrayType::kF64);
  if (!array) return array.error();
  Eigen::MatrixXd values(array->rows, array->columns);
  if (!array->bytes.empty()) std::memcpy(values.data(), array->bytes.data(), array->bytes.size());
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (!std::isfinite(values.data()[i]))
      return error_at(name, offset_of(*array) + sizeof(double) * i, "a value is not finite");
  return values;
}

Result<std::vector<std::int64_t>> CheckpointFile::integers(std::string_view name) const {
  const Result<NamedArray> array = checked(name, ArrayType::kI64);
  if (!array) return array.error();
  std::vector<std::int64_t> values(array->bytes.size() / sizeof(std::int64_t));
  if (!array->bytes.empty()) std::memcpy(values.data(), array->bytes.data(), array->bytes.size());
  return values;
}

Result<std::string> CheckpointFile::text(std::string_view name) const {
  const Result<NamedArray> array = checked(name, ArrayType::kText);
  if (!array) return array.error();
  return std::string(reinterpret_cast<const char*>(array->bytes.data()), array->bytes.size());
}

}  // namespace tremolo
