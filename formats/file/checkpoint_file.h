// A file of named arrays that saves a finished stage of a long computation.
//
// Little-endian. A header of 64 bytes, a table with one 64-byte entry per array, the arrays in the
// table's order, and nothing else: every byte is under a checksum (XXH3-64).
//   header: magic (8 characters), version (u32), arrays (u32), bytes of the file (u64), hash of the
//     table (u64), 24 bytes zero, hash of the header's first 56 bytes (u64)
//   entry: name (32 characters, padded with zeros), type (u32), zero (u32), rows, columns, hash of
//     the array (u64 each)
// Other versions are refused: a checkpoint is useful only to the program that wrote it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "formats/file/input_file.h"

namespace tremolo {

namespace checkpoint_layout {
inline constexpr std::array<char, 8> kMagic = {'T', 'R', 'E', 'M', 'C', 'K', 'P', 'T'};
inline constexpr std::uint32_t kVersion = 1;
inline constexpr std::size_t kHeaderSize = 64;
inline constexpr std::size_t kVersionAt = 8, kArraysAt = 12, kFileSizeAt = 16, kTableHashAt = 24,
                             kReservedAt = 32, kHeaderHashAt = 56;
inline constexpr std::size_t kEntrySize = 64;
inline constexpr std::size_t kNameSize = 32;
inline constexpr std::size_t kTypeAt = 32, kZeroAt = 36, kRowsAt = 40, kColumnsAt = 48,
                             kHashAt = 56;
inline constexpr std::uint32_t kMaxArrays = 256;
}  // namespace checkpoint_layout

// f64 and i64 are column-major; a text is bytes x 1, and an empty array is 0 x 1.
enum class ArrayType : std::uint32_t { kF64 = 1, kI64 = 2, kText = 3 };

// bytes: rows * columns elements in the order of memory, the caller's or the file's.
struct NamedArray {
  std::string name;  // 1 to 32 characters, none of them zero
  ArrayType type = ArrayType::kF64;
  std::uint64_t rows = 0;
  std::uint64_t columns = 0;
  std::span<const std::byte> bytes;
};

// The values must outlive the array. `values` holds rows * columns numbers, column by column.
NamedArray named_array(std::string name, std::span<const double> values, std::uint64_t rows,
                       std::uint64_t columns = 1);
NamedArray named_array(std::string name, std::span<const std::int64_t> values);
NamedArray named_array(std::string name, std::string_view text);

// Errors: kSystem with the path for a file that cannot be written; kContent for names that are too
// long or not unique, and for sizes that do not match their bytes. The file is written whole or not
// at all.
Status write_checkpoint_file(const std::string& path, std::span<const NamedArray> arrays);

// Reads a checkpoint file, which is untrusted: header and table are checked when it is opened, an
// array when it is requested. Errors: kSystem when it cannot be opened, else kContent;
// they name the file, the array and the byte.
class CheckpointFile {
 public:
  static Result<CheckpointFile> open(const std::string& path);
  // `bytes` must outlive the object; `name` is for messages.
  static Result<CheckpointFile> from_memory(std::span<const std::byte> bytes,
                                            std::string name = "checkpoint");

  const std::vector<NamedArray>& arrays() const { return arrays_; }

  // Copies, all numbers finite. An array that is not there, of another type or damaged is an error.
  Result<Eigen::MatrixXd> matrix(std::string_view name) const;
  Result<std::vector<std::int64_t>> integers(std::string_view name) const;
  Result<std::string> text(std::string_view name) const;

 private:
  Status parse_header();
  Status parse_table();
  Status parse_entry(std::size_t index, std::uint64_t& offset);
  Error error_at(std::string_view where, std::uint64_t offset, const std::string& what) const;
  Result<NamedArray> checked(std::string_view name, ArrayType type) const;
  std::uint64_t offset_of(const NamedArray& array) const;

  MappedFile file_;
  std::string name_;
  std::span<const std::byte> bytes_;
  std::vector<NamedArray> arrays_;
  std::vector<std::uint64_t> hashes_;
};

}  // namespace tremolo
