#include "tests/lab/report/table.h"

#include <cmath>

#include <fmt/format.h>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

void append_line(const std::vector<std::string>& cells, std::string& out) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) out += ',';
    if (cells[i].find_first_of(",\"\r\n") == std::string::npos) {
      out += cells[i];
      continue;
    }
    out += '"';
    for (const char c : cells[i]) {
      if (c == '"') out += '"';
      out += c;
    }
    out += '"';
  }
  out += '\n';
}

}  // namespace

Table without_repeats(Table table, std::size_t columns) {
  for (std::size_t r = table.rows.size(); r-- > 1;)  // upwards, so that the row above is whole
    for (std::size_t c = 0; c < columns && table.rows[r][c] == table.rows[r - 1][c]; ++c)
      table.rows[r][c].clear();
  return table;
}

std::string cell(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : std::string();
}

std::string to_csv(const Table& table) {
  std::string text;
  append_line(table.columns, text);
  for (const std::vector<std::string>& row : table.rows) append_line(row, text);
  return text;
}

Status write_csv(const Table& table, const std::string& path) {
  return write_file(path, to_csv(table));
}

}  // namespace tremolo
