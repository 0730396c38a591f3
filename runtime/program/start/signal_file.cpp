#include "runtime/program/start/signal_file.h"

#include <cctype>

#include "formats/file/text_scanner.h"
#include "formats/file/whole_file.h"

namespace tremolo {

Result<SignalTable> read_signal(const std::string& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_signal_table(*text, path);
}

Result<SignalTable> parse_signal_table(std::string_view text, const std::string& path) {
  TextScanner scanner(text, path,
                      {.comment = '#', .commas = true, .lines = true, .open_end = true});
  SignalTable table;
  const auto is_head = [](std::string_view word) {
    return !word.empty() &&
           (std::isalpha(static_cast<unsigned char>(word.front())) != 0 || word.front() == '"');
  };
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
