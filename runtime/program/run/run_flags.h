// The flags of `tremolo run` that other programs take too.
#pragma once

#include "runtime/program/run/run_options.h"

namespace CLI {
class App;
}

namespace tremolo {

// What a body is but for --modes, how it is stepped, what pushes it and how it begins.
void add_body_flags(CLI::App& app, RunOptions& options);
void add_modes_flag(CLI::App& app, RunOptions& options);

}  // namespace tremolo
