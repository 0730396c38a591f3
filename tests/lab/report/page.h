// One self-contained HTML page: headings, paragraphs, tables, pictures, verdicts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "tests/lab/report/criterion.h"
#include "tests/lab/report/table.h"

namespace tremolo {

// Text is escaped; `html` parts are not. No scripts, no external files; readable without colour and
// in print; a table of contents from the sections. In a table, rows whose first cells are
// empty go on the group above.
class Page {
 public:
  Page(std::string title, std::string subtitle);

  void section(std::string_view title);   // h2, in the table of contents
  void heading(std::string_view title);   // h3
  void paragraph(std::string_view text);  // `code` between backticks
  void table(const Table& table, std::string_view caption = {});
  void figure(std::string_view svg, std::string_view caption);
  void criteria(const std::vector<Criterion>& criteria);  // a table with each one's verdict
  void last_section_first();                              // for what is known last and read first
  Status write(const std::string& path) const;            // temporary name, then rename

 private:
  std::string title_;
  std::string subtitle_;
  struct Section {
    std::string title;
    std::string body;
  };
  std::string& body();  // where the next part belongs

  std::string preface_;  // before the first section
  std::vector<Section> sections_;
};

}  // namespace tremolo
