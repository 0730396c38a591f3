// Names of objects and materials as users select them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

namespace tremolo {

// Makes names printable and different from earlier ones; `nameless` replaces an empty name.
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
