// A file of named sections -> their bytes. The reader trusts nothing: every size product, bound and
// overlap is checked before anything is allocated, and a section's checksum on its first use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/file/mapped_file.h"
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

// An open file: header and table are checked by open(); sections are checked and their checksum
// verified when they are first asked for. Errors are kContent and name the section, the offset,
// what was expected and what was found; kSystem if the file cannot be read. Reading from several
// threads needs a lock of the caller's.
class SectionFile {
 public:
  // Maps the file: only what is used is touched.
  static Result<SectionFile> open(const std::string& path, const section_layout::FileKind& kind);
  // Borrows the bytes: they must outlive the object and whatever it returns. `name` is for errors.
  static Result<SectionFile> from_memory(std::span<const std::byte> bytes, std::string name,
                                         const section_layout::FileKind& kind);

  const std::vector<FileSection>& sections() const { return sections_; }
  std::uint16_t minor_version() const { return minor_; }
  // Null if there is none.
  const FileSection* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }

  // Every critical section is there and every critical one known, what belongs together is, and
  // types and shapes fit.
  Status check_shapes(std::span<const section_layout::SectionShape> shapes) const;

  // The verified contents, as they lie in the file, aligned for doubles. Valid while the object
  // lives. An error if the section is not there or of another type.
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
