// A table for CSV files and for the page.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// Every row has as many cells as there are columns.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

// The same for reading: in the first `columns` columns a cell is empty where it and all to its left
// repeat the row above.
Table without_repeats(Table table, std::size_t columns);

// digits: significant ones; not finite becomes an empty cell.
std::string cell(double value, int digits = 4);

// RFC 4180, but that lines end in a line feed alone.
std::string to_csv(const Table& table);

// Writes to a temporary name and renames. Errors: kSystem.
Status write_csv(const Table& table, const std::string& path);

}  // namespace tremolo
