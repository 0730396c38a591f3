#include "formats/surface/ply_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "common/decimal.h"
#include "formats/file/text_scanner.h"

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

// A value of the type T that stands at `bytes`.
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
    const std::string_view name = scanner_.token();
    if (element.name == "vertex" && !property.list && name.size() == 1 && name[0] >= 'x' &&
        name[0] <= 'z')
      property.axis = name[0] - 'x';
    property.corners = element.name == "face" && property.list &&
                       (name == "vertex_indices" || name == "vertex_index");
    element.properties.push_back(property);
    return true;
  }

  Result<PlyHeader> finish() {
    int axes = 0;
    bool vertices = false;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "face" && !vertices)
        return scanner_.problem("expected the vertices before the faces");
      vertices = vertices || element.name == "vertex";
      for (const PlyProperty& property : element.properties)
        if (property.axis >= 0) ++axes;
      if (element.properties.empty() && element.count > 0)
        return scanner_.problem("an element has no property");
    }
    if (axes != 3) return scanner_.problem("expected x, y and z of the vertices");
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
  return HeaderParser(bytes, name).parse();
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
