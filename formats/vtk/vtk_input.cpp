#include "formats/vtk/vtk_input.h"

#include <bit>
#include <type_traits>

namespace tremolo {

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
  if (encoding != "ASCII" && encoding != "BINARY") return text_.fail("ASCII or BINARY", encoding);
  binary_ = encoding == "BINARY";
  return true;
}

template <class Stored, class T>
bool VtkInput::read_bytes(std::uint64_t count, std::string_view what, std::vector<T>& values) {
  if (!text_.at_line_end()) return text_.fail("the end of the line", text_.token());
  text_.rest_of_line();
  // Legacy binary files are big-endian on every machine.
  ByteScanner bytes(whole_, path_, text_.offset(), std::endian::native != std::endian::big);
  bool good = bytes.fits(count, sizeof(Stored), what);
  if (good) values.resize(count);
  for (std::uint64_t n = 0; good && n < count; ++n) {
    Stored stored{};
    good = bytes.read(stored, what);
    values[n] = static_cast<T>(stored);
  }
  if (!good) {
    error_ = bytes.error();
    return false;
  }
  text_ = TextScanner(whole_, path_, {.binary_file = true});
  text_.seek(bytes.offset());
  return true;
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
  if (type == "unsigned_char") return read_bytes<std::uint8_t>(count, what, values);
  return text_.fail("a type of numbers such as float or int", type);
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
