// Tables of numbers in CSV files: motions and loads in time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/load_signal.h"
#include "common/result.h"

namespace tremolo {

// Rows of numbers, separated by commas or blanks, all of one length out of `widths`. A first line
// that begins with a letter is a head; # begins a comment. what: what a row holds, for errors.
// Errors: kContent with the line; a table without rows.
Result<std::vector<std::vector<double>>> parse_rows(std::string_view text, const std::string& path,
                                                    const std::vector<std::size_t>& widths,
                                                    const std::string& what);

// A load's course: a line a moment, time (s) and value (dimensionless; the load is multiplied by
// it). Errors: kSystem for a file that cannot be read, kContent with the line for what is no such
// table.
Result<SignalTable> read_signal(const std::string& path);
// The same of the file's contents; `path` stands in errors.
Result<SignalTable> parse_signal_table(std::string_view text, const std::string& path);

}  // namespace tremolo
