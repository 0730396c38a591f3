#include "formats/sections/section_writer.h"

#include <algorithm>
#include <cstring>

#include "common/hash.h"
#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

using namespace section_layout;

void put_entry(std::span<std::byte> table, std::size_t at, const SectionContent& section,
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

// Receives bytes for an offset of the file, in ascending order except the header, which is last.
using PlacedSink = std::function<Status(std::size_t offset, std::span<const std::byte> bytes)>;

// The section's bytes to the sink; their hash.
Result<std::uint64_t> put_section(const SectionContent& section, std::size_t offset,
                                  const PlacedSink& sink) {
  if (!section.stream) {
    if (Status status = sink(offset, section.bytes); !status) return status.error();
    return hash_bytes(section.bytes);
  }
  Hasher hasher;
  std::size_t at = offset;
  const Status status = section.stream([&](std::span<const std::byte> bytes) {
    hasher.add(bytes);
    const std::size_t begin = at;
    at += bytes.size();
    return sink(begin, bytes);
  });
  if (!status) return status.error();
  return hasher.hash();
}

std::size_t front_size(const SectionList& list) {
  return aligned(kHeaderSize + list.sections.size() * kEntrySize);
}

std::size_t file_size(const SectionList& list) {
  std::size_t size = front_size(list);
  for (const SectionContent& section : list.sections) size = aligned(size + section.size());
  return size;
}

// Header, table and sections to the sink.
Status put_file(const SectionList& list, const PlacedSink& sink) {
  const std::size_t table_size = list.sections.size() * kEntrySize;
  std::vector<std::byte> front(front_size(list));
  const std::byte padding[kAlignment] = {};
  std::size_t offset = front.size();
  std::size_t at = kHeaderSize;
  for (const SectionContent& section : list.sections) {
    Result<std::uint64_t> hash = put_section(section, offset, sink);
    if (!hash) return hash.error();
    put_entry(front, at, section, offset, *hash);
    const std::size_t end = offset + section.size();
    offset = aligned(end);
    if (Status status = sink(end, std::span(padding).first(offset - end)); !status) return status;
    at += kEntrySize;
  }
  std::memcpy(front.data() + header::kMagicAt, list.kind.magic.data(), list.kind.magic.size());
  put<std::uint16_t>(front, header::kMajorAt, list.kind.major);
  put<std::uint16_t>(front, header::kMinorAt, list.minor);
  put<std::uint32_t>(front, header::kSectionsAt, static_cast<std::uint32_t>(list.sections.size()));
  put<std::uint64_t>(front, header::kFileSizeAt, file_size(list));
  put<std::uint64_t>(front, header::kTableHashAt,
                     hash_bytes(std::span(front).subspan(kHeaderSize, table_size)));
  put<std::uint64_t>(front, header::kHeaderHashAt,
                     hash_bytes(std::span(front).first(header::kHeaderHashAt)));
  return sink(0, front);
}

}  // namespace

Result<std::vector<std::byte>> encode_sections(const SectionList& list) {
  std::vector<std::byte> file(file_size(list));
  const Status status = put_file(list, [&](std::size_t offset, std::span<const std::byte> bytes) {
    std::copy(bytes.begin(), bytes.end(), file.begin() + offset);
    return Status(Success{});
  });
  if (!status) return status.error();
  return file;
}

Status write_sections(const std::string& path, const SectionList& list) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  const Status status = put_file(list, [&](std::size_t offset, std::span<const std::byte> bytes) {
    return file->write_at(offset, bytes);
  });
  if (!status) return status;
  return file->commit();
}

}  // namespace tremolo
