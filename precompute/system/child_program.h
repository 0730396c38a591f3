// Programs of this project that are started as child processes.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tremolo {

// Returns the path of the program `name` in this program's folder; empty if it cannot be executed.
std::string program_beside(const std::string& name, std::string& looked_at);

// A descriptor of this process that the child gets under another number.
struct PassedDescriptor {
  int here = -1;
  int there = -1;
};

// Runs a program to its end, its stdout thrown away. silent: its stderr as well. Returns its wait
// status. Throws Failure (kSystem) if it cannot be started.
int run_child(const std::string& program, std::vector<std::string> arguments,
              const std::optional<PassedDescriptor>& passed, bool silent);

}  // namespace tremolo
