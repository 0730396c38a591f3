#include "tests/lab/report/report.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "runtime/io/page/document.h"
#include "tests/lab/work/failure.h"

namespace tremolo {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Invalid UTF-8 in a name must not end the program.
std::string text_of(const OrderedJson& json, int indent = -1) {
  return json.dump(indent, ' ', false, OrderedJson::error_handler_t::replace);
}

template <class Charts>
OrderedJson all_to_json(const Charts& charts) {
  OrderedJson all = OrderedJson::array();
  for (const auto& chart : charts) all.push_back(to_json(chart));
  return all;
}

// Says which part of its outline a report lacks; empty if it has all.
std::string lacking(const OrderedJson& report) {
  const auto text = [](const OrderedJson& in, const char* name) {
    return in.is_object() && in.contains(name) && in[name].is_string();
  };
  if (!text(report, "title") || !text(report, "subtitle")) return "a title and a subtitle";
  if (!report.contains("sections") || !report["sections"].is_array()) return "sections";
  for (const OrderedJson& section : report["sections"]) {
    if (!text(section, "title")) return "a section's title";
    if (!section.contains("parts") || !section["parts"].is_array()) return "a section's parts";
    for (const OrderedJson& part : section["parts"])
      if (!text(part, "kind") || !part.contains(part["kind"].get<std::string>()))
        return "a part's kind, and what it is";
  }
  return {};
}

}  // namespace

Report::Report(std::string directory, std::string title, std::string subtitle)
    : directory_(std::move(directory)),
      json_{{"title", std::move(title)},
            {"subtitle", std::move(subtitle)},
            {"sections", OrderedJson::array()}} {}

void Report::add(const char* kind, OrderedJson what) {
  OrderedJson& sections = json_["sections"];
  if (sections.empty()) section({});
  sections.back()["parts"].push_back({{"kind", kind}, {kind, std::move(what)}});
}

void Report::section(std::string title) {
  json_["sections"].push_back({{"title", std::move(title)}, {"parts", OrderedJson::array()}});
}

void Report::heading(std::string_view text) {
  add("heading", text);
}

void Report::paragraph(std::string_view text) {
  add("paragraph", text);
}

void Report::table(const Table& table, std::string_view caption, const std::string& csv,
                   std::size_t repeating) {
  add("table", {{"caption", caption},
                {"csv", csv},
                {"columns", table.columns},
                {"rows", without_repeats(table, repeating).rows}});
  if (!csv.empty()) file(table, csv);
}

void Report::file(const Table& table, const std::string& csv) const {
  or_fail(write_csv(table, (std::filesystem::path(directory_) / csv).string()));
}

void Report::figure(const std::vector<Chart>& charts, int columns, int height,
                    std::string_view caption) {
  add("charts", {{"caption", caption},
                 {"columns", columns},
                 {"height", height},
                 {"charts", all_to_json(charts)}});
}

void Report::figure(const std::vector<CellChart>& charts, std::string_view caption) {
  add("cells", {{"caption", caption}, {"charts", all_to_json(charts)}});
}

void Report::criteria(const std::vector<Criterion>& criteria) {
  OrderedJson list = to_json(criteria);
  for (std::size_t i = 0; i < criteria.size(); ++i) list[i]["verdict"] = verdict(criteria[i]);
  add("criteria", std::move(list));
}

void Report::last_section_first() {
  OrderedJson& sections = json_["sections"];
  if (!sections.empty()) std::rotate(sections.begin(), std::prev(sections.end()), sections.end());
}

std::string Report::write() const {
  const std::filesystem::path directory(directory_);
  std::string page = (directory / "index.html").string();
  or_fail(write_file((directory / "report.json").string(), text_of(json_) + "\n"));
  or_fail(write_page(json_, page));
  return page;
}

Status write_page(const OrderedJson& report, const std::string& path) {
  return write_file(path, page_document(text_of(report)));
}

Status page_of_file(const std::string& report, const std::string& path) {
  const Result<std::string> text = read_whole_file(report);
  if (!text) return text.error();
  const OrderedJson json = OrderedJson::parse(*text, nullptr, false);
  if (json.is_discarded()) return content_error(report + ": this is not JSON");
  if (const std::string what = lacking(json); !what.empty())
    return content_error(report + ": a report has " + what);
  return write_page(json, path);
}

}  // namespace tremolo
