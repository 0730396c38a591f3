#include "formats/file/printable_text.h"

#include <algorithm>

namespace tremolo {
namespace {

// Length in bytes of the first code point of `text`, 0 if it is invalid.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Longer than need be, a half of a surrogate pair, or above the last code point.
  if ((first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) > 0x9f) ||
      (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) > 0x8f))
    return 0;
  return length;
}

// ASCII's and the second set (U+0080 to U+009F), which terminals obey too.
bool is_control(std::string_view code_point) {
  const auto first = static_cast<unsigned char>(code_point[0]);
  if (code_point.size() == 1) return first < 0x20 || first == 0x7f;
  return first == 0xc2 && static_cast<unsigned char>(code_point[1]) < 0xa0;
}

}  // namespace

std::string printable_text(std::string_view text, std::size_t bytes) {
  std::string printable;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view code_point = text.substr(0, std::max<std::size_t>(length, 1));
    const std::string_view shown = length == 0 ? "?" : is_control(code_point) ? " " : code_point;
    if (printable.size() + shown.size() > bytes) break;
    printable += shown;
    text.remove_prefix(code_point.size());
  }
  return printable;
}

bool is_printable_text(std::string_view text, std::size_t bytes) {
  return text.size() <= bytes && printable_text(text, bytes) == text &&
         text.find('\0') == std::string_view::npos;
}

std::string UniqueNames::take(std::string_view wanted) {
  // Room for a number.
  std::string name = printable_text(wanted, kLongestName - 16);
  if (name.find_first_not_of(' ') == std::string::npos) name = nameless_;
  if (taken_.insert(name).second) return name;
  std::uint64_t& count = repeats_.try_emplace(name, 1).first->second;
  for (;;) {
    std::string numbered = name + " " + std::to_string(++count);
    if (taken_.insert(numbered).second) return numbered;
  }
}

}  // namespace tremolo
