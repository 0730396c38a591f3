// The lines of a .veg file with those of the files it includes.
#pragma once

#include <list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "formats/file/scanner.h"

namespace tremolo {

// Reads lines that are neither blank nor comments, following *INCLUDE to files in the same folder.
// Each file is included at most once, so that memory is bounded by their sizes.
class VegInput {
 public:
  VegInput(std::string_view text, const std::string& path);

  // Goes to the next line; false at the end or after an error (see failed()).
  bool next_line();
  bool failed() const { return !error_.message.empty(); }
  // The current line, or the end of the file.
  TextScanner& line() { return sources_.back().scanner; }
  // Moves to the next line, an error if there is none; what: "a vertex".
  bool expect_line(std::string_view what);
  const Error& error() const { return failed() ? error_ : line_error(); }

 private:
  struct Source {
    TextScanner scanner;
    bool started = false;
  };
  const Error& line_error() const { return sources_.back().scanner.error(); }
  bool advance(Source& source);
  bool include();

  std::string path_;
  std::list<std::string> texts_;  // of the included files; scanners point into them
  std::vector<Source> sources_;   // the file being read is the last
  std::set<std::string> included_;
  Error error_;
};

}  // namespace tremolo
