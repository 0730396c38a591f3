// The keywords and number lists of a legacy VTK file, the same whether it is text or binary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/file/scanner.h"

namespace tremolo {

// Reads that fail return false and leave error().
class VtkInput {
 public:
  VtkInput(std::string_view text, const std::string& path);

  // The three lines before DATASET: version, title, ASCII or BINARY.
  bool read_header();
  bool binary() const { return binary_; }

  // Numbers of a type that the file names ("float", "vtktypeint64"), from the next line on if the
  // file is binary. A list that cannot fit in the rest of the file is refused before it is stored.
  bool read_list(const std::string& type, std::uint64_t count, std::string_view what,
                 std::vector<std::int64_t>& values);
  bool read_list(const std::string& type, std::uint64_t count, std::string_view what,
                 std::vector<double>& values);

  // Skips an array without numbers or without use: of any of VTK's types, also "string", "bit" and
  // "variant". Allocates nothing.
  bool skip_list(const std::string& type, std::uint64_t count, std::string_view what);

  TextScanner& text() { return text_; }
  // Begins a part at the last token: a fault in the list that follows is said to be there.
  void begin_part(const std::string& keyword) { part_ = text_.problem("in " + keyword).message; }
  const std::string& part() const { return part_; }
  // An error in the part.
  bool fail(const std::string& complaint);
  const Error& error() const { return error_.message.empty() ? text_.error() : error_; }

 private:
  template <class T>
  bool read_values(const std::string& type, std::uint64_t count, std::string_view what,
                   std::vector<T>& values);
  template <class Stored, class T>
  bool read_bytes(std::uint64_t count, std::string_view what, std::vector<T>& values);
  // The bytes of a binary list begin on the next line; the text continues after them.
  bool begin_bytes();
  bool end_bytes(const ByteScanner& bytes, bool good);
  bool skip_strings(std::uint64_t count);
  bool skip_binary_strings(std::uint64_t count);

  std::string_view whole_;
  std::string path_;
  TextScanner text_;
  bool binary_ = false;
  std::string part_;
  Error error_;
};

// The cell array with region numbers (region_rank()); an empty name if there is none.
struct VtkCellArray {
  std::string name;
  std::vector<double> values;
};

// Reads from POINT_DATA or CELL_DATA on; the input is positioned after `keyword`. Unreadable data
// end it without an error, since the mesh is complete: `complaint` then gives the reason, and is
// empty otherwise.
VtkCellArray read_region_array(VtkInput& input, std::string keyword, std::string& complaint);

// Skips the arrays of FIELD and the text of METADATA, whose keyword has been read.
bool skip_vtk_field(VtkInput& input);
void skip_vtk_metadata(VtkInput& input);

}  // namespace tremolo
