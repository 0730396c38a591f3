// The command line of `tremolo`.
#pragma once

#include <string>

#include "runtime/apps/tremolo/run/run_options.h"

namespace tremolo {

// The command line of a command that reads a scene.
struct SceneCommand {
  std::string file;  // path of the scene
  GivenFlags flags;
  std::string degree;  // of --degree; empty: not given
  bool json = false;
  std::string beside = {};  // of --beside; empty: not given
};

// Parses the words and runs the command; returns the exit code.
int run_command_line(int count, char** words);

// `tremolo inspect`. Prints the contents of a basis file and verifies every checksum; with a
// selector, prints its vertices instead. Returns the exit code; errors are printed on stderr.
int inspect_command(const std::string& path, const std::string& select, bool json);

}  // namespace tremolo
