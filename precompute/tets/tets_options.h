// Options of `tremolo-precompute tets`.
#pragma once

#include <string>
#include <variant>

#include "precompute/problem/problem_request.h"

namespace tremolo {

struct TetsOptions {
  ProblemRequest solid;
  std::string output_path;
  std::string config_path;  // of --config; empty: none
  int cells = 32;           // of the distances' grid along the surface's longest side; 0: none
  bool json = false;
  std::string command_line;  // the part that affects the result
};

// Parses the words after `tets`. Returns the exit code if the program ends here (the text has been
// printed).
std::variant<TetsOptions, int> parse_tets_line(int count, char** words);

}  // namespace tremolo
