// --signal: a load's course in time from a CSV.
#pragma once

#include <string>
#include <string_view>

#include "common/load_signal.h"
#include "common/result.h"

namespace tremolo {

// A line a moment: time (s) and value (dimensionless; the load is multiplied by it), separated by a
// comma or blanks. A first line that begins with a letter is a head; # begins a comment. Errors:
// kSystem for a file that cannot be read, kContent with the line for what is no such table.
Result<SignalTable> read_signal(const std::string& path);
// The same of the file's contents; `path` stands in errors.
Result<SignalTable> parse_signal_table(std::string_view text, const std::string& path);

}  // namespace tremolo
