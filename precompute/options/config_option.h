// The option --config FILE of tremolo-precompute.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace tremolo {

// Adds the option. Since CLI11 opens the file itself, parsing throws Failure (kSystem) if it exists
// but is not a regular file, which might never end.
void add_config_option(CLI::App& app, const std::string& description);

// Returns the option's value after parsing; empty if it was not given.
std::string config_path(const CLI::App& app);

}  // namespace tremolo
