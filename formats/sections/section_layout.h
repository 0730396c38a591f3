// The bytes that all kinds of Tremolo's binary files share: a header, a table, named sections.
// docs/basis-format.md, "Bytes", is the same in prose; change both or neither.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tremolo::section_layout {

inline constexpr std::size_t kAlignment = 64;
// The offset at which the next section may begin, after one that ends at `offset`.
constexpr std::size_t aligned(std::size_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}
inline constexpr std::uint32_t kMaxSections = 256;

// Header, 64 bytes at offset 0; everything little-endian.
inline constexpr std::size_t kHeaderSize = 64;
namespace header {
inline constexpr std::size_t kMagicAt = 0;        // 8 characters
inline constexpr std::size_t kMajorAt = 8;        // u16
inline constexpr std::size_t kMinorAt = 10;       // u16
inline constexpr std::size_t kSectionsAt = 12;    // u32, number of table entries
inline constexpr std::size_t kFileSizeAt = 16;    // u64, bytes of the whole file
inline constexpr std::size_t kTableHashAt = 24;   // u64, XXH3-64 of the table
inline constexpr std::size_t kReservedAt = 32;    // 24 bytes, zero
inline constexpr std::size_t kHeaderHashAt = 56;  // u64, XXH3-64 of bytes 0..55
}  // namespace header

// Table: one 64-byte entry per section, directly after the header.
inline constexpr std::size_t kEntrySize = 64;
namespace entry {
inline constexpr std::size_t kNameAt = 0;      // 16 characters, padded with zeros
inline constexpr std::size_t kTypeAt = 16;     // u32, ElementType
inline constexpr std::size_t kFlagsAt = 20;    // u32, bit 0: critical; others zero
inline constexpr std::size_t kOffsetAt = 24;   // u64, from the start of the file, multiple of 64
inline constexpr std::size_t kSizeAt = 32;     // u64, bytes = rows * columns * element size
inline constexpr std::size_t kRowsAt = 40;     // u64
inline constexpr std::size_t kColumnsAt = 48;  // u64
inline constexpr std::size_t kHashAt = 56;     // u64, XXH3-64 of the section's bytes
}  // namespace entry
inline constexpr std::size_t kNameSize = 16;
inline constexpr std::uint32_t kCritical = 1;

// In a basis file kF32 and kI16 are of version 1.1.
enum class ElementType : std::uint32_t {
  kU8 = 1,
  kU32 = 2,
  kU64 = 3,
  kF64 = 4,
  kF32 = 5,
  kI16 = 6
};

// Bytes of one element; 0 for an unknown type.
constexpr std::size_t element_size(ElementType type) {
  switch (type) {
    case ElementType::kU8:
      return 1;
    case ElementType::kI16:
      return 2;
    case ElementType::kF32:
    case ElementType::kU32:
      return 4;
    case ElementType::kU64:
    case ElementType::kF64:
      return 8;
  }
  return 0;
}

// The element type of which a section's values are in memory.
template <class T>
inline constexpr ElementType kTypeOf{};
template <>
inline constexpr ElementType kTypeOf<std::uint8_t> = ElementType::kU8;
template <>
inline constexpr ElementType kTypeOf<std::uint32_t> = ElementType::kU32;
template <>
inline constexpr ElementType kTypeOf<std::uint64_t> = ElementType::kU64;
template <>
inline constexpr ElementType kTypeOf<double> = ElementType::kF64;
template <>
inline constexpr ElementType kTypeOf<float> = ElementType::kF32;
template <>
inline constexpr ElementType kTypeOf<std::int16_t> = ElementType::kI16;

// The identity of a kind of file. what: for messages, "a basis file".
struct FileKind {
  std::array<char, 8> magic;
  std::uint16_t major;  // a reader refuses another
  const char* what;
};

// The section may have any number of rows.
inline constexpr std::uint64_t kAnyRows = ~std::uint64_t{0};

// critical: every file has the section, and a reader that does not know it refuses the file.
// needs: another section that is there whenever this one is; empty: none.
struct SectionShape {
  std::string_view name;
  ElementType type;
  std::uint64_t rows;
  std::uint64_t columns;
  bool critical = false;
  std::string_view needs = {};
};

}  // namespace tremolo::section_layout
