// Reads files of named sections. The files are untrusted: every size product, bound and overlap is
// checked before anything is allocated, and a section's checksum on its first use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/file/input_file.h"
#include "formats/sections/section_layout.h"

namespace tremolo {

// One row of the file's table.
struct FileSection {
  std::string name;
  section_layout::ElementType type{};
  bool critical = false;
  std::uint64_t offset = 0;  // bytes from the start of the file
  std::uint64_t size = 0;    // bytes
  std::uint64_t rows = 0;
  std::uint64_t columns = 0;
  std::uint64_t hash = 0;
};

// An open file: open() checks header and table; a section is checked and its checksum verified when
// it is first requested. Errors are kContent and give the section, the offset, the expected and the
// found value; kSystem if the file cannot be read. The caller must lock it for reading from several
// threads.
class SectionFile {
 public:
  // Maps the file: only the pages in use are read.
  static Result<SectionFile> open(const std::string& path, const section_layout::FileKind& kind);
  // Borrows the bytes: they must outlive the object and whatever it returns. `name` is for errors.
  static Result<SectionFile> from_memory(std::span<const std::byte> bytes, std::string name,
                                         const section_layout::FileKind& kind);

  const std::vector<FileSection>& sections() const { return sections_; }
  std::uint16_t minor_version() const { return minor_; }
  // Null if there is none.
  const FileSection* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }

  // Checks that every critical section exists and every critical one is known, that sections which
  // need each other exist together, and that types and shapes match.
  Status check_shapes(std::span<const section_layout::SectionShape> shapes) const;

  // The verified contents, as stored in the file, aligned for doubles. Valid while the object
  // exists. An error if the section is missing or of another type.
  Result<std::span<const std::byte>> contents(std::string_view name,
                                              section_layout::ElementType type);
  template <class T>
  Result<std::span<const T>> elements(std::string_view name) {
    const Result<std::span<const std::byte>> bytes = contents(name, section_layout::kTypeOf<T>);
    if (!bytes) return bytes.error();
    return std::span(reinterpret_cast<const T*>(bytes->data()), bytes->size() / sizeof(T));
  }
  // T is double or float; each value is finite.
  template <class T>
  Result<std::span<const T>> finite(std::string_view name);
  Result<std::string_view> text(std::string_view name);

  // The checksum of every section, used or not.
  Status verify_all();

  // "NAME: WHERE at byte OFFSET: WHAT"
  Error error_at(std::string_view where, std::uint64_t offset, const std::string& what) const;

 private:
  SectionFile() = default;
  Status parse_header(const section_layout::FileKind& kind);
  Status parse_table();
  Status parse_entry(std::size_t index);
  Status check_packing() const;
  Status verify(std::size_t index);

  std::string name_;
  MappedFile file_;
  std::unique_ptr<std::byte[]> copy_;  // when borrowed bytes are not aligned for doubles
  std::span<const std::byte> bytes_;
  std::uint16_t minor_ = 0;
  std::vector<FileSection> sections_;
  std::vector<bool> verified_;
};

}  // namespace tremolo
