// The lines of an Abaqus input file: keywords with parameters, followed by their data.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/file/text_scanner.h"

namespace tremolo {

// A line such as `*Element, type=C3D4, elset="Part one"`.
struct InpKeyword {
  std::string name;  // upper case, without the star: "ELEMENT", "SOLID SECTION"
  std::map<std::string, std::string> parameters;  // name in upper case -> value as written

  bool has(const std::string& parameter) const { return parameters.contains(parameter); }
  // Empty if it is not given.
  std::string value(const std::string& parameter) const;
};

// Goes over keywords and data lines; comments (two stars) and empty lines are passed over.
class InpInput {
 public:
  InpInput(std::string_view text, const std::string& path);

  // Goes to the next keyword; false at the end of the file or after an error (failed()).
  bool next_keyword(InpKeyword& keyword);
  // Goes to the next data line of this keyword; false if there is none.
  bool next_data();
  // True if the current data line ends in a comma: its record continues on the next line.
  bool continues() const;

  TextScanner& line() { return scanner_; }
  bool failed() const { return failed_; }
  const Error& error() const { return scanner_.error(); }
  Error problem(const std::string& text) const { return scanner_.problem(text); }

 private:
  enum class Line { kKeyword, kData, kEnd };
  // Goes to the start of the next line that is neither empty nor a comment.
  Line advance();
  std::string_view rest() const;

  TextScanner scanner_;
  bool started_ = false;
  bool failed_ = false;
  bool at_keyword_ = false;  // a keyword was met while data were looked for
};

}  // namespace tremolo
