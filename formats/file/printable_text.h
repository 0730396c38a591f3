// Text of files for display.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

namespace tremolo {

// Makes any bytes displayable as a name or a message: UTF-8 without control characters, at most
// `bytes` bytes; other bytes become '?' or a blank.
std::string printable_text(std::string_view text, std::size_t bytes);
// True if the text is already in that form.
bool is_printable_text(std::string_view text, std::size_t bytes);

constexpr std::size_t kLongestName = 256;

// Names of objects and materials as users select them. Makes names printable and different from
// earlier ones; `nameless` replaces an empty name.
class UniqueNames {
 public:
  explicit UniqueNames(std::string nameless) : nameless_(std::move(nameless)) {}

  std::string take(std::string_view wanted);

 private:
  std::string nameless_;
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::uint64_t> repeats_;
};

}  // namespace tremolo
