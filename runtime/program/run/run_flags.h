// The flags of `tremolo run` that other programs take too.
#pragma once

#include "runtime/program/run/run_options.h"

namespace CLI {
class App;
}

namespace tremolo {

// Adds the flags of a body's model (except --modes), integrator, load and start.
void add_body_flags(CLI::App& app, RunOptions& options);
void add_modes_flag(CLI::App& app, RunOptions& options);

}  // namespace tremolo
