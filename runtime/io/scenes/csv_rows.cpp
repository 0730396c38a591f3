#include "runtime/io/scenes/csv_rows.h"

#include <algorithm>
#include <cctype>

#include "formats/file/input_file.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

bool is_head(std::string_view word) {
  return !word.empty() &&
         (std::isalpha(static_cast<unsigned char>(word.front())) != 0 || word.front() == '"');
}

}  // namespace

Result<std::vector<std::vector<double>>> parse_rows(std::string_view text, const std::string& path,
                                                    const std::vector<std::size_t>& widths,
                                                    const std::string& what) {
  TextScanner scanner(text, path,
                      {.comment = '#', .commas = true, .lines = true, .open_end = true});
  const std::size_t most = *std::max_element(widths.begin(), widths.end());
  std::vector<std::vector<double>> rows;
  bool more = !scanner.at_end();
  if (more && is_head(scanner.peek())) more = scanner.next_line();
  for (; more; more = scanner.next_line()) {
    std::vector<double> row;
    while (!scanner.at_line_end() && row.size() <= most) {
      if (!scanner.read(row.emplace_back(), "a number")) return scanner.error();
    }
    const bool fits = std::find(widths.begin(), widths.end(), row.size()) != widths.end();
    if (!fits || (!rows.empty() && rows.front().size() != row.size()))
      return scanner.problem("expected " + what + ", the same in every line; found " +
                             (row.size() > most ? "more" : std::to_string(row.size())) +
                             " numbers");
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return content_error(path + ": there are no rows; expected " + what);
  return rows;
}

Result<SignalTable> read_signal(const std::string& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_signal_table(*text, path);
}

Result<SignalTable> parse_signal_table(std::string_view text, const std::string& path) {
  TextScanner scanner(text, path,
                      {.comment = '#', .commas = true, .lines = true, .open_end = true});
  SignalTable table;
  bool more = !scanner.at_end();
  if (more && is_head(scanner.peek())) more = scanner.next_line();
  for (; more; more = scanner.next_line()) {
    double time = 0.0, value = 0.0;
    if (!scanner.read(time, "a time in s") || !scanner.read(value, "a value"))
      return scanner.error();
    if (!scanner.at_line_end()) {
      scanner.fail("two numbers on a line, time and value", scanner.token());
      return scanner.error();
    }
    table.times.push_back(time);
    table.values.push_back(value);
  }
  if (const std::string problem = table_problem(table); !problem.empty())
    return content_error(path + ": no signal: " + problem +
                         " (a line a moment: time in s, value; times ascend)");
  return table;
}

}  // namespace tremolo
