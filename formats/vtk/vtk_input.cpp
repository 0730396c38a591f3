#include "formats/vtk/vtk_input.h"

#include <array>
#include <bit>
#include <limits>
#include <type_traits>
#include <utility>

#include "common/text.h"

namespace tremolo {
namespace {

// Legacy binary files are big-endian on every machine.
constexpr bool kSwapsBigEndian = std::endian::native != std::endian::big;

// Bytes of a number in a binary file, 0 for a type that is not a number.
std::size_t vtk_type_size(std::string_view type) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 16> kSizes = {
      {{"char", 1},
       {"signed_char", 1},
       {"unsigned_char", 1},
       {"short", 2},
       {"unsigned_short", 2},
       {"int", 4},
       {"unsigned_int", 4},
       {"vtkIdType", 4},
       {"float", 4},
       {"double", 8},
       {"long", 8},
       {"unsigned_long", 8},
       {"long_long", 8},
       {"unsigned_long_long", 8},
       {"vtktypeint64", 8},
       {"vtktypeuint64", 8}}};
  for (const auto& [name, size] : kSizes)
    if (name == type) return size;
  return 0;
}

}  // namespace

VtkInput::VtkInput(std::string_view text, const std::string& path)
    : whole_(text), path_(path), text_(text, path) {}

bool VtkInput::fail(const std::string& complaint) {
  error_ = content_error(part_ + ": " + complaint);
  return false;
}

bool VtkInput::read_header() {
  const std::string_view first = text_.rest_of_line();
  if (!first.starts_with("# vtk DataFile Version "))
    return text_.fail("`# vtk DataFile Version ...`", first);
  text_.rest_of_line();
  const std::string_view encoding = text_.token();
  const std::string plain = upper_case(encoding);
  if (plain != "ASCII" && plain != "BINARY") return text_.fail("ASCII or BINARY", encoding);
  binary_ = plain == "BINARY";
  return true;
}

bool VtkInput::begin_bytes() {
  if (!text_.at_line_end()) return text_.fail("the end of the line", text_.token());
  text_.rest_of_line();
  return true;
}

bool VtkInput::end_bytes(const ByteScanner& bytes, bool good) {
  if (!good) {
    error_ = bytes.error();
    return false;
  }
  text_ = TextScanner(whole_, path_, {.binary_file = true});
  text_.seek(bytes.offset());
  return true;
}

template <class Stored, class T>
bool VtkInput::read_bytes(std::uint64_t count, std::string_view what, std::vector<T>& values) {
  if (!begin_bytes()) return false;
  ByteScanner bytes(whole_, path_, text_.offset(), kSwapsBigEndian);
  bool good = bytes.fits(count, sizeof(Stored), what);
  if (good) values.resize(count);
  for (std::uint64_t n = 0; good && n < count; ++n) {
    Stored stored{};
    good = bytes.read(stored, what);
    values[n] = static_cast<T>(stored);
  }
  return end_bytes(bytes, good);
}

template <class T>
bool VtkInput::read_values(const std::string& type, std::uint64_t count, std::string_view what,
                           std::vector<T>& values) {
  constexpr bool kReal = std::is_floating_point_v<T>;
  const bool real = type == "float" || type == "double";
  if (real && !kReal) return text_.fail("a type of integers", type);
  if (!binary_) {
    if (!text_.fits(count, 2, what)) return false;
    values.resize(count);
    for (T& value : values)
      if (!text_.read(value, what)) return false;
    return true;
  }
  if (type == "float") return read_bytes<float>(count, what, values);
  if (type == "double") return read_bytes<double>(count, what, values);
  if (type == "int" || type == "vtkIdType") return read_bytes<std::int32_t>(count, what, values);
  if (type == "unsigned_int") return read_bytes<std::uint32_t>(count, what, values);
  if (type == "vtktypeint64" || type == "long")
    return read_bytes<std::int64_t>(count, what, values);
  if (type == "vtktypeuint64" || type == "unsigned_long")
    return read_bytes<std::uint64_t>(count, what, values);
  if (type == "short") return read_bytes<std::int16_t>(count, what, values);
  if (type == "unsigned_short") return read_bytes<std::uint16_t>(count, what, values);
  // A char is read as its bits: no list of a mesh that matters holds negative ones.
  if (type == "char") return read_bytes<std::uint8_t>(count, what, values);
  if (type == "signed_char") return read_bytes<std::int8_t>(count, what, values);
  if (type == "unsigned_char") return read_bytes<std::uint8_t>(count, what, values);
  return text_.fail("a type of numbers such as float or int", type);
}

// In a text file a string has its own line.
bool VtkInput::skip_strings(std::uint64_t count) {
  if (!begin_bytes() || !text_.fits(count, 1, "strings")) return false;
  for (std::uint64_t n = 0; n < count; ++n) text_.rest_of_line();
  return true;
}

// The two highest bits of a string's first byte give the size of its length field: 3, 2, 1 and 0
// mean 1, 2, 4 and 8 bytes, whose lower bits are the length.
bool VtkInput::skip_binary_strings(std::uint64_t count) {
  if (!begin_bytes()) return false;
  ByteScanner bytes(whole_, path_, text_.offset(), kSwapsBigEndian);
  bool good = bytes.fits(count, 1, "strings");
  for (std::uint64_t n = 0; good && n < count; ++n) {
    std::uint8_t byte = 0;
    good = bytes.read(byte, "the length of a string");
    std::uint64_t length = byte & 0x3f;
    for (int more = (1 << (3 - (byte >> 6))) - 1; good && more > 0; --more) {
      good = bytes.read(byte, "the length of a string");
      length = length << 8 | byte;
    }
    good = good && bytes.skip(length, 1, "the bytes of a string");
  }
  return end_bytes(bytes, good);
}

bool VtkInput::skip_list(const std::string& type, std::uint64_t count, std::string_view what) {
  if (type == "string" || type == "utf8_string")
    return binary_ ? skip_binary_strings(count) : skip_strings(count);
  if (!binary_) {
    // A variant is a type and a value: two tokens.
    if (type == "variant" && count > std::numeric_limits<std::uint64_t>::max() / 2)
      return text_.fits(count, 2, what);
    const std::uint64_t tokens = type == "variant" ? 2 * count : count;
    if (!text_.fits(tokens, 2, what)) return false;
    for (std::uint64_t n = 0; n < tokens; ++n)
      if (text_.token().empty()) return text_.fail(what, "");
    return true;
  }
  const std::size_t size = vtk_type_size(type);
  if (type != "bit" && size == 0)
    return text_.fail("a type of numbers such as float or int, bit or string", type);
  if (!begin_bytes()) return false;
  ByteScanner bytes(whole_, path_, text_.offset(), kSwapsBigEndian);
  const bool good = type == "bit" ? bytes.skip(count / 8 + (count % 8 != 0), 1, what)
                                  : bytes.skip(count, size, what);
  return end_bytes(bytes, good);
}

bool VtkInput::read_list(const std::string& type, std::uint64_t count, std::string_view what,
                         std::vector<std::int64_t>& values) {
  return read_values(type, count, what, values);
}

bool VtkInput::read_list(const std::string& type, std::uint64_t count, std::string_view what,
                         std::vector<double>& values) {
  return read_values(type, count, what, values);
}

}  // namespace tremolo
