// The numbers of an MSH file, the same whether the file is text or binary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/file/byte_scanner.h"
#include "formats/file/text_scanner.h"

namespace tremolo {

// The minimum of numbers of each kind in an item of a list.
struct MshItem {
  std::size_t integers = 0;  // int32 in a binary file
  std::size_t sizes = 0;     // u64
  std::size_t reals = 0;     // f64
};

// Walks over the sections of a file. Reads that fail return false and leave error().
class MshInput {
 public:
  // Reads the $MeshFormat section, with which the file begins, and refuses other versions.
  static Result<MshInput> open(std::string_view text, const std::string& path);

  // "4.1", "2" or "2.2" and its like; open() refuses others.
  const std::string& version() const { return version_; }
  bool binary() const { return binary_; }
  // "MSH 4.1 binary"
  std::string format() const;

  // The name of the next section without its $, empty at the end of the file.
  bool next_section(std::string_view& name);
  // Moves past the $End line of a section that is not read.
  bool skip_section(std::string_view name);
  // Expects the $End line of a section that was read.
  bool end_section(std::string_view name);

  // A part of a section that a binary file stores as bytes: from the next line on.
  bool begin_data();
  void end_data();
  bool integer(std::int64_t& value, std::string_view what);
  bool size(std::uint64_t& value, std::string_view what);
  bool real(double& value, std::string_view what);
  bool fits(std::uint64_t count, MshItem item, std::string_view what);

  // For the parts that are text in every file.
  TextScanner& text() { return text_; }
  // Adds the position of the last number read.
  Error problem(const std::string& complaint) const;
  const Error& error() const { return in_bytes_ ? bytes_.error() : text_.error(); }

 private:
  MshInput(std::string_view text, const std::string& path);
  Status read_format();

  std::string_view whole_;
  std::string path_;
  TextScanner text_;
  ByteScanner bytes_;
  std::string version_;
  bool binary_ = false;
  bool swap_ = false;
  bool in_bytes_ = false;
};

}  // namespace tremolo
