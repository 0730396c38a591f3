// Bytes of files of named sections for tests: reading, changing, making the checksums right again.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/hash.h"
#include "formats/sections/section_layout.h"

namespace tremolo::testing {

using Bytes = std::vector<std::byte>;
// Returns true if the file's reader accepts the bytes.
using Accepts = std::function<bool(const Bytes&)>;

inline Bytes read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

template <class T>
T get(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

// Makes all checksums right again, as an attacker would.
inline void reseal(Bytes& bytes) {
  const auto count = get<std::uint32_t>(bytes, section_layout::header::kSectionsAt);
  const std::size_t table_size = std::min<std::size_t>(count * section_layout::kEntrySize,
                                                       bytes.size() - section_layout::kHeaderSize);
  for (std::size_t at = section_layout::kHeaderSize;
       at + section_layout::kEntrySize <= section_layout::kHeaderSize + table_size;
       at += section_layout::kEntrySize) {
    const auto offset = get<std::uint64_t>(bytes, at + section_layout::entry::kOffsetAt);
    const auto size = get<std::uint64_t>(bytes, at + section_layout::entry::kSizeAt);
    if (offset > bytes.size() || size > bytes.size() - offset) continue;
    put(bytes, at + section_layout::entry::kHashAt,
        hash_bytes(std::span(bytes).subspan(offset, size)));
  }
  put(bytes, section_layout::header::kTableHashAt,
      hash_bytes(std::span(bytes).subspan(section_layout::kHeaderSize, table_size)));
  put(bytes, section_layout::header::kHeaderHashAt,
      hash_bytes(std::span(bytes).first(section_layout::header::kHeaderHashAt)));
}

inline std::size_t entry_of(const Bytes& bytes, std::string_view name) {
  for (std::size_t at = section_layout::kHeaderSize;; at += section_layout::kEntrySize)
    if (name == reinterpret_cast<const char*>(bytes.data() + at)) return at;
}

inline std::size_t offset_of(const Bytes& bytes, std::string_view name) {
  return get<std::uint64_t>(bytes, entry_of(bytes, name) + section_layout::entry::kOffsetAt);
}

// Every field of header and table set to hostile values, checksums made right again: refused, or
// (a name, an unknown optional section, a minor version) read without harm. ASan watches.
inline void expect_no_field_is_trusted(const Bytes& bytes, const Accepts& accepts) {
  using namespace section_layout;
  const auto sections = get<std::uint32_t>(bytes, header::kSectionsAt);
  const std::uint64_t hostile[] = {0,
                                   1,
                                   7,
                                   63,
                                   64,
                                   65,
                                   0x7fffffffu,
                                   0xffffffffu,
                                   bytes.size() - 1,
                                   bytes.size(),
                                   bytes.size() + 1,
                                   0x2000000000000000u,
                                   0x7fffffffffffffffu,
                                   std::numeric_limits<std::uint64_t>::max()};
  std::vector<std::pair<std::size_t, std::size_t>> fields = {
      {header::kMagicAt, 8},    {header::kMajorAt, 2},    {header::kMinorAt, 2},
      {header::kSectionsAt, 4}, {header::kFileSizeAt, 8}, {header::kReservedAt, 8}};
  for (std::size_t s = 0; s < sections; ++s) {
    const std::size_t at = kHeaderSize + s * kEntrySize;
    for (const auto& [offset, size] : {std::pair{entry::kNameAt, std::size_t{8}},
                                       {entry::kTypeAt, 4},
                                       {entry::kFlagsAt, 4},
                                       {entry::kOffsetAt, 8},
                                       {entry::kSizeAt, 8},
                                       {entry::kRowsAt, 8},
                                       {entry::kColumnsAt, 8}})
      fields.emplace_back(at + offset, size);
  }
  for (const auto& [at, size] : fields)
    for (std::uint64_t value : hostile) {
      Bytes changed = bytes;
      std::memcpy(changed.data() + at, &value, size);
      if (changed == bytes) continue;
      reseal(changed);
      const bool accepted = accepts(changed);
      const std::size_t in_entry = (at - kHeaderSize) % kEntrySize;
      const bool harmless =
          at == header::kMinorAt ||
          (at >= kHeaderSize && (in_entry == entry::kNameAt || in_entry == entry::kFlagsAt));
      EXPECT_TRUE(!accepted || harmless) << "field at " << at << " set to " << value;
    }
}

inline void expect_every_damaged_byte_is_noticed(const Bytes& bytes, const Accepts& accepts) {
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (unsigned bit : {0x01u, 0x80u, 0xffu}) {
      Bytes damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(bit);
      EXPECT_FALSE(accepts(damaged)) << "byte " << at;
    }
}

inline void expect_every_truncation_is_noticed(const Bytes& bytes, const Accepts& accepts) {
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(accepts(Bytes(bytes.begin(), bytes.begin() + size))) << size << " bytes";
}

}  // namespace tremolo::testing
