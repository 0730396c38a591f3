// One self-contained HTML page: headings, paragraphs, tables, pictures, verdicts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/program/report/table.h"

namespace tremolo {

// Something that was promised, what was measured, and whether it holds. decides: false for figures
// that are shown without a bound of their own; they never fail a run.
struct Criterion {
  std::string what;      // "ep4, energy drift over 3.33 million steps"
  std::string bound;     // "<= 1e-9"
  std::string measured;  // "4e-13"
  bool met = false;
  bool decides = true;
};

// Text is escaped; `html` parts are not. No scripts, no external files; readable without colour and
// in print; a table of contents from the sections.
class Page {
 public:
  Page(std::string title, std::string subtitle);

  void section(std::string_view title);   // h2, in the table of contents
  void heading(std::string_view title);   // h3
  void paragraph(std::string_view text);  // `code` between backticks
  void table(const Table& table, std::string_view caption = {});
  void figure(std::string_view svg, std::string_view caption);
  void criteria(const std::vector<Criterion>& criteria);  // a table with "met" / "MISSED" / "shown"
  Status write(const std::string& path) const;            // temporary name, then rename

 private:
  std::string title_;
  std::string subtitle_;
  std::string body_;
  std::vector<std::string> sections_;
};

// 0 if every deciding criterion is met, 6 otherwise.
int exit_code(const std::vector<Criterion>& criteria);

}  // namespace tremolo
