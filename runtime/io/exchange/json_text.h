// Pieces of a JSON text, for the little that a glTF file needs.
#pragma once

#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace tremolo {

// The text in quotes, with escapes; a byte that is not valid UTF-8 becomes '?'.
std::string json_string(std::string_view text);

// The shortest text that reads back as the same number, which must be finite.
template <class Number>
std::string json_number(Number value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

// "[a,b,c]"; the entries are JSON already.
inline std::string json_list(const std::vector<std::string>& entries) {
  std::string text = "[";
  for (const std::string& entry : entries) {
    if (text.size() > 1) text += ',';
    text += entry;
  }
  return text + "]";
}

// The same of numbers in a range.
template <class Range>
std::string json_numbers(const Range& numbers) {
  std::string text = "[";
  for (const auto& number : numbers) {
    if (text.size() > 1) text += ',';
    text += json_number(number);
  }
  return text + "]";
}

}  // namespace tremolo
