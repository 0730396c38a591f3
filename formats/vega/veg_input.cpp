#include "formats/vega/veg_input.h"

#include <filesystem>
#include <string_view>
#include <utility>

#include "formats/file/input_file.h"

namespace tremolo {
namespace {

constexpr TextStyle kVegStyle{.comment = '#', .commas = true, .lines = true};

}  // namespace

VegInput::VegInput(std::string_view text, const std::string& path) : path_(path) {
  sources_.push_back({TextScanner(text, path, kVegStyle)});
}

bool VegInput::advance(Source& source) {
  if (source.started) return source.scanner.next_line();
  source.started = true;
  return !source.scanner.at_end();
}

bool VegInput::next_line() {
  while (!failed()) {
    if (!advance(sources_.back())) {
      if (sources_.size() == 1) return false;
      sources_.pop_back();
    } else if (line().peek() == "*INCLUDE") {
      if (!include()) return false;
    } else {
      return true;
    }
  }
  return false;
}

bool VegInput::expect_line(std::string_view what) {
  if (next_line()) return true;
  if (!failed()) line().fail(what, "");
  return false;
}

bool VegInput::include() {
  TextScanner& scanner = line();
  scanner.token();
  std::string name;
  if (!scanner.read_word(name, "the name of a file")) {
    error_ = scanner.error();
    return false;
  }
  if (scanner.remaining() == 0) {
    scanner.fail("a line end behind the name of a file (the file may be cut off)", "");
    error_ = scanner.error();
    return false;
  }
  // A mesh must not make the program open files elsewhere on the machine. The system ignores names
  // after a NUL, so that two names could be one file.
  constexpr std::string_view kNever("/\\\0", 3);
  if (name.find_first_of(kNever) != std::string::npos || !included_.insert(name).second) {
    scanner.fail("the name of a file in the same folder, each once", name);
    error_ = scanner.error();
    return false;
  }
  const std::string sibling = (std::filesystem::path(path_).parent_path() / name).string();
  Result<std::string> text = read_whole_file(sibling);
  if (!text) {
    error_ = text.error();
    error_.message += " (included by " + path_ + ")";
    return false;
  }
  texts_.push_back(std::move(*text));
  sources_.push_back({TextScanner(texts_.back(), sibling, kVegStyle)});
  return true;
}

}  // namespace tremolo
