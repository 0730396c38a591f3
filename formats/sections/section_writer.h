// Named sections -> the bytes of a file (section_layout.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/sections/section_layout.h"

namespace tremolo {

// Receives the next bytes of the output.
using ByteSink = std::function<Status(std::span<const std::byte> bytes)>;

// A section to be written. bytes: its contents, rows * columns elements in the order of memory;
// they must stay until it is written. stream: if set, it supplies them piece by piece instead.
struct SectionContent {
  section_layout::SectionShape shape;
  std::span<const std::byte> bytes;
  std::function<Status(const ByteSink&)> stream = {};

  std::size_t row_size() const { return shape.columns * element_size(shape.type); }
  std::size_t size() const { return shape.rows * row_size(); }
};

// Sections of one file in the order in which they are written; names are at most 16 characters and
// each appears once. minor: the file's minor version.
struct SectionList {
  section_layout::FileKind kind;
  std::uint16_t minor = 0;
  std::vector<SectionContent> sections;
};

// The whole file; the same sections give the same bytes. Errors are those of the streams.
Result<std::vector<std::byte>> encode_sections(const SectionList& list);

// The same, written under a temporary name and renamed to `path`. Errors: also kSystem for a file
// that cannot be written.
Status write_sections(const std::string& path, const SectionList& list);

template <class List>
std::span<const std::byte> bytes_of(const List& list) {
  return std::as_bytes(std::span(list.data(), list.size()));
}

}  // namespace tremolo
