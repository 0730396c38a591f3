// --config FILE of tremolo-precompute.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace tremolo {

// CLI11 opens the file by itself: parsing throws Failure (kSystem) if it is there and is no regular
// file, of which the end may never come.
void add_config_option(CLI::App& app, const std::string& description);

// What the option was given; empty: nothing. After parsing.
std::string config_path(const CLI::App& app);

}  // namespace tremolo
