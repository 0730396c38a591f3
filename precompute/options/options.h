// Parser of tremolo-precompute's command line.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "precompute/options/precompute_options.h"

namespace tremolo {

struct CommandLine {
  PrecomputeOptions options;
  bool json = false;
  std::string settings;                    // final values of all options, key=value lines
  std::vector<std::string> petsc_options;  // words after --
};

// Returns the command line, or the exit code if the program ends here (--help, --version, wrong
// usage; the text has been printed).
std::variant<CommandLine, int> parse_command_line(int count, char** words);

}  // namespace tremolo
