// Reads a state from the CSV of a run.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "runtime/integrator.h"

namespace tremolo {

// q and p of the row nearest to `time` (s), or of the last one. text: the contents of the file; a
// last line without a line end may be cut off and is ignored. path: for errors. modes: the required
// number of columns q0 ... and p0 .... Errors: kContent with the line.
Result<State> parse_state_row(std::string_view text, const std::string& path,
                              std::optional<double> time, Eigen::Index modes);

}  // namespace tremolo
