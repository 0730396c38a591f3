#include "formats/polygons/ply_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "common/text.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

std::optional<PlyType> ply_type(std::string_view word) {
  struct Named {
    std::string_view old_name, name;
    PlyType type;
  };
  static constexpr std::array kTypes = {
      Named{"char", "int8", PlyType::kInt8},      Named{"uchar", "uint8", PlyType::kUint8},
      Named{"short", "int16", PlyType::kInt16},   Named{"ushort", "uint16", PlyType::kUint16},
      Named{"int", "int32", PlyType::kInt32},     Named{"uint", "uint32", PlyType::kUint32},
      Named{"float", "float32", PlyType::kFloat}, Named{"double", "float64", PlyType::kDouble}};
  for (const Named& named : kTypes)
    if (word == named.old_name || word == named.name) return named.type;
  return std::nullopt;
}

// The value of type T at `bytes`.
template <class T>
double ply_value(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  // The compiler for pages has no std::bit_cast.
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return static_cast<double>(value);
}

constexpr std::array kAxes = {PlyRole::kX, PlyRole::kY, PlyRole::kZ};

PlyRole role_of(std::string_view element, std::string_view name, bool list) {
  struct Named {
    std::string_view name;
    PlyRole role;
  };
  // Names by MeshLab, Blender, VCGlib, PCL and CloudCompare.
  static constexpr std::array kOfVertices = {Named{"x", PlyRole::kX},
                                             Named{"y", PlyRole::kY},
                                             Named{"z", PlyRole::kZ},
                                             Named{"nx", PlyRole::kNormalX},
                                             Named{"ny", PlyRole::kNormalY},
                                             Named{"nz", PlyRole::kNormalZ},
                                             Named{"s", PlyRole::kU},
                                             Named{"u", PlyRole::kU},
                                             Named{"texture_u", PlyRole::kU},
                                             Named{"texture_s", PlyRole::kU},
                                             Named{"t", PlyRole::kV},
                                             Named{"v", PlyRole::kV},
                                             Named{"texture_v", PlyRole::kV},
                                             Named{"texture_t", PlyRole::kV},
                                             Named{"red", PlyRole::kRed},
                                             Named{"green", PlyRole::kGreen},
                                             Named{"blue", PlyRole::kBlue},
                                             Named{"alpha", PlyRole::kAlpha},
                                             Named{"r", PlyRole::kRed},
                                             Named{"g", PlyRole::kGreen},
                                             Named{"b", PlyRole::kBlue},
                                             Named{"a", PlyRole::kAlpha},
                                             Named{"diffuse_red", PlyRole::kRed},
                                             Named{"diffuse_green", PlyRole::kGreen},
                                             Named{"diffuse_blue", PlyRole::kBlue}};
  static constexpr std::array kOfFaces = {Named{"vertex_indices", PlyRole::kCorners},
                                          Named{"vertex_index", PlyRole::kCorners},
                                          Named{"texcoord", PlyRole::kCornerUvs}};
  const auto found = [name](const auto& table) {
    for (const Named& named : table)
      if (name == named.name) return named.role;
    return PlyRole::kNone;
  };
  if (!list) return element == "vertex" ? found(kOfVertices) : PlyRole::kNone;
  if (element == "face") return found(kOfFaces);
  const bool strips = element == "tristrips" && found(kOfFaces) == PlyRole::kCorners;
  return strips ? PlyRole::kStrips : PlyRole::kNone;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& name)
      : scanner_(bytes, name, {.lines = true, .open_end = true}), bytes_(bytes.size()) {}

  Result<PlyHeader> parse() {
    if (scanner_.token() != "ply") return scanner_.problem("expected ply");
    while (scanner_.next_line()) {
      const std::string_view word = scanner_.token();
      if (word == "end_header") return finish();
      if (word == "comment" || word == "obj_info") continue;
      // Some writers forget the word before a line about themselves.
      if (header_.elements.empty() && word != "format" && word != "element" && word != "property")
        continue;
      const bool good = word == "format"     ? format()
                        : word == "element"  ? element()
                        : word == "property" ? property()
                                             : scanner_.fail("a ply keyword", word);
      if (!good) return scanner_.error();
    }
    return scanner_.problem("expected end_header before the end of the file");
  }

 private:
  bool format() {
    const std::string_view form = scanner_.token();
    if (form == "ascii")
      header_.form = PlyForm::kText;
    else if (form == "binary_little_endian")
      header_.form = PlyForm::kLittleEndian;
    else if (form == "binary_big_endian")
      header_.form = PlyForm::kBigEndian;
    else
      return scanner_.fail("ascii, binary_little_endian or binary_big_endian", form);
    return true;
  }

  bool element() {
    PlyElement element;
    element.name = scanner_.token();
    if (!scanner_.read(element.count, "how many there are")) return false;
    if (element.count > bytes_)
      return scanner_.fail("no more items than the file has bytes", std::to_string(element.count));
    header_.elements.push_back(std::move(element));
    return true;
  }

  bool property() {
    if (header_.elements.empty()) return scanner_.fail("an element before", "property");
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    std::string_view word = scanner_.token();
    if (word == "list") {
      property.list = true;
      const std::optional<PlyType> type = ply_type(scanner_.token());
      if (!type) return scanner_.fail("a list's type of number", "");
      property.count_type = *type;
      word = scanner_.token();
    }
    const std::optional<PlyType> type = ply_type(word);
    if (!type) return scanner_.fail("a type of number", word);
    property.type = *type;
    property.role = role_of(element.name, scanner_.token(), property.list);
    element.properties.push_back(property);
    return true;
  }

  Result<PlyHeader> finish() {
    std::array<int, 3> axes{};
    for (const PlyElement& element : header_.elements) {
      for (const PlyProperty& property : element.properties)
        for (int axis = 0; axis < 3; ++axis) axes[axis] += property.role == kAxes[axis] ? 1 : 0;
      if (element.properties.empty() && element.count > 0)
        return scanner_.problem("an element has no property");
    }
    if (axes != std::array{1, 1, 1}) return scanner_.problem("expected x, y and z of the vertices");
    header_.size = std::min(scanner_.offset(), bytes_);
    // Behind the end of this line the numbers begin.
    const std::string_view text = scanner_.text();
    const std::size_t end = text.find('\n', header_.size);
    header_.size = end == std::string_view::npos ? bytes_ : end + 1;
    return std::move(header_);
  }

  TextScanner scanner_;
  std::size_t bytes_;
  PlyHeader header_;
};

}  // namespace

Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& name) {
  const std::string_view start = without_mark(bytes).substr(0, 5);
  if (!start.starts_with("ply\r") || start.ends_with('\n'))
    return HeaderParser(bytes, name).parse();
  // Lines of old Macs. What follows the header may hold any bytes.
  constexpr std::string_view kEnd = "end_header\r";
  const std::size_t end = bytes.find(kEnd);
  if (end == std::string_view::npos)
    return content_error(name + ": expected end_header before the end of the file");
  std::string lines(bytes);
  std::replace(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(end + kEnd.size()), '\r',
               '\n');
  return HeaderParser(lines, name).parse();
}

bool PlyNumbers::read(PlyType type, double& value) {
  if (form_ == PlyForm::kText) return read_text(value);
  static constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  const std::size_t size = kSizes[static_cast<std::size_t>(type)];
  if (size > body_.size() - at_) return false;
  const char* bytes = body_.data() + at_;
  const bool swap =
      (form_ == PlyForm::kLittleEndian) != (std::endian::native == std::endian::little);
  at_ += size;
  switch (type) {
    case PlyType::kInt8:
      value = ply_value<std::int8_t>(bytes, swap);
      break;
    case PlyType::kUint8:
      value = ply_value<std::uint8_t>(bytes, swap);
      break;
    case PlyType::kInt16:
      value = ply_value<std::int16_t>(bytes, swap);
      break;
    case PlyType::kUint16:
      value = ply_value<std::uint16_t>(bytes, swap);
      break;
    case PlyType::kInt32:
      value = ply_value<std::int32_t>(bytes, swap);
      break;
    case PlyType::kUint32:
      value = ply_value<std::uint32_t>(bytes, swap);
      break;
    case PlyType::kFloat:
      value = ply_value<float>(bytes, swap);
      break;
    case PlyType::kDouble:
      value = ply_value<double>(bytes, swap);
      break;
  }
  return true;
}

bool PlyNumbers::read_text(double& value) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
  while (at_ < body_.size() && blank(body_[at_])) ++at_;
  std::size_t end = at_;
  while (end < body_.size() && !blank(body_[end])) ++end;
  if (end == at_) return false;
  const auto [stop, code] = read_decimal(body_.data() + at_, body_.data() + end, value);
  if (code != std::errc{} || stop != body_.data() + end) return false;
  at_ = end;
  return true;
}

Error PlyNumbers::error(const std::string& name) const {
  return content_error(name + ", byte " + std::to_string(offset_ + at_) +
                       ": expected a number, found " +
                       (at_ == body_.size() ? "the end of the file" : "something else"));
}

}  // namespace tremolo
