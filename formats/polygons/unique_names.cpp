#include "formats/polygons/unique_names.h"

#include "formats/file/printable_text.h"

namespace tremolo {

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
