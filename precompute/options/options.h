// The command line of tremolo-precompute.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "precompute/options/precompute_options.h"

namespace tremolo {

struct CommandLine {
  PrecomputeOptions options;
  bool json = false;
  std::string settings;                    // what all options came out as, key=value lines
  std::vector<std::string> petsc_options;  // what stood behind --
};

// The command line, or the exit code when there is nothing more to do (--help, --version, wrong
// usage; the text has been printed).
std::variant<CommandLine, int> parse_command_line(int count, char** words);

}  // namespace tremolo
