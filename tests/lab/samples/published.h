// Numbers that others have published: CSV files in assets/published, each with its source and units
// in comments.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "formats/file/scanner.h"

namespace tremolo {

// Location of the files, relative to the top of the repository.
inline constexpr const char* kPublishedDirectory = "assets/published";

// Reads one file: comments from # to the end of a line, a line of column names, then a record per
// line. All functions throw a Failure with file and line: kContent for damaged files.
class PublishedTable {
 public:
  // columns: the line of names, with commas. Throws kSystem if the file cannot be read.
  PublishedTable(const std::string& directory, const std::string& file, std::string_view columns);

  // Goes to the next record; false at the end of the file.
  bool next();
  // The next value of the record; `what` names it in a message. A number is finite and not below
  // `least`.
  std::string word(std::string_view what);
  double number(std::string_view what, double least = 0.0);
  // Empty if the file has `none`.
  std::optional<double> number_or(std::string_view none, std::string_view what);

  // Throws: `problem` with the line of the value that was read last.
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  std::string text_;
  TextScanner scanner_;
};

}  // namespace tremolo
