// A report: sections of text, tables, charts and criteria, as report.json and as a page.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/output/chart.h"
#include "tests/lab/report/criterion.h"
#include "tests/lab/report/table.h"

namespace tremolo {

// Collects the contents of a report and writes its CSV files in between. In texts, `code` is
// between backticks; nothing is parsed as HTML. A file that cannot be written is a Failure
// (kSystem).
class Report {
 public:
  // directory: of all files; it exists.
  Report(std::string directory, std::string title, std::string subtitle);

  void section(std::string title);      // begins one
  void heading(std::string_view text);  // within a section
  void paragraph(std::string_view text);
  // csv: the file that gets the whole table, empty for none. repeating: in so many leading columns
  // the page leaves out what repeats the row above.
  void table(const Table& table, std::string_view caption = {}, const std::string& csv = {},
             std::size_t repeating = 0);
  // A table that is a file and not on the page.
  void file(const Table& table, const std::string& csv) const;
  // Charts in rows of `columns`, each `height` px high, with one legend.
  void figure(const std::vector<Chart>& charts, int columns, int height, std::string_view caption);
  // Cell charts, with the legend of the first.
  void figure(const std::vector<CellChart>& charts, std::string_view caption);
  void criteria(const std::vector<Criterion>& criteria);  // each with its verdict
  void last_section_first();                              // for results known last and read first

  const nlohmann::ordered_json& json() const { return json_; }
  // Writes report.json and index.html; returns the path of the page.
  std::string write() const;

 private:
  void add(const char* kind, nlohmann::ordered_json what);

  std::string directory_;
  nlohmann::ordered_json json_;
};

// The page that shows `report` (runtime/io/page/document.h). Errors: kSystem.
Status write_page(const nlohmann::ordered_json& report, const std::string& path);

// Writes the page of a report that a file holds. Errors: kContent if it is not JSON or its outline
// is not that of a report, with the file's name; kSystem.
Status page_of_file(const std::string& report, const std::string& path);

}  // namespace tremolo
