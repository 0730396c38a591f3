// The subcommands of `tremolo`. Each returns an exit code; errors are printed on stderr.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/program/run_options.h"

namespace tremolo {

// Prints what a basis file holds and verifies every checksum; with a selector, the vertices that it
// chooses instead.
int inspect_command(const std::string& path, const std::string& select, bool json);

// Runs every body of the list. json: one object on stdout, also when a run failed.
int run_command(const std::vector<RunOptions>& bodies, bool json);

// Energy over time of several runs (their run.csv) in one picture, .svg or .png.
int plot_command(const std::vector<std::string>& directories, const std::string& output);

// "tremolo: message" on stderr; the error's exit code.
int report_error(const Error& error);

}  // namespace tremolo
