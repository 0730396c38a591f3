// Tables of numbers in CSV files: motions and loads in time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/load_signal.h"
#include "common/result.h"

namespace tremolo {

// Rows of numbers, separated by commas or blanks; their common length is one of `widths`. A first
// line that begins with a letter is a header; # begins a comment. what: the contents of a row, for
// errors. Errors: kContent with the line; a table without rows.
Result<std::vector<std::vector<double>>> parse_rows(std::string_view text, const std::string& path,
                                                    const std::vector<std::size_t>& widths,
                                                    const std::string& what);

// A load's course: a line per time, with time (s) and value (dimensionless; it multiplies the
// load). Errors: kSystem for a file that cannot be read, kContent with the line for another kind of
// table.
Result<SignalTable> read_signal(const std::string& path);
// The same for the file's contents; `path` is for errors.
Result<SignalTable> parse_signal_table(std::string_view text, const std::string& path);

}  // namespace tremolo
