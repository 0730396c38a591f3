// `tremolo run`.
#pragma once

#include <vector>

#include "runtime/program/run/run_options.h"

namespace tremolo {

// Runs every body of the list. json: one object on stdout, also when a run failed. The exit code;
// errors are printed on stderr.
int run_command(const std::vector<RunOptions>& bodies, bool json);

}  // namespace tremolo
