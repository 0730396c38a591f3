// The command line of tremolo-precompute, and the request that it becomes.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "precompute/problem/precompute_request.h"

namespace tremolo {

// The options as they were read. Texts are not parsed yet.
struct CommandLine {
  SolidTexts solid;
  BasisRequest basis;
  std::vector<std::string> response_at;  // selectors, or "load"
  SolveRequest solve;                    // without `solver` and `memory`
  std::string solver = "auto";
  std::uint64_t memory = 0;      // bytes a rank may use; 0: the free memory
  CheckpointRequest checkpoint;  // without the folder
  FitRequest fit;                // without `measured`: no fit
  OutputRequest output;          // without `encoding`
  std::string encoding = "full";
  std::string select;                      // selector of --select; empty: none
  std::string import_basis, import_cubic;  // VegaFEM's files; empty: none
  bool mass_given = false;                 // --mass was given
  std::string config_path;                 // of --config; empty: none
  std::string settings;                    // final values of all options, key=value lines
  std::vector<std::string> petsc_options;  // words after --
};

// Returns the command line, or the exit code if the program ends here (--help, --version, wrong
// usage; the text has been printed).
std::variant<CommandLine, int> parse_command_line(int count, char** words);

// A command: computes a basis, imports one, or shows a selection or what is held and loaded.
using Command = std::variant<PrecomputeRequest, ImportRequest, SelectRequest, PreviewRequest>;

// Parses the texts and rejects what is wrong for every mesh. Throws Failure (kUsage, kContent).
Command read_command(const CommandLine& line);

}  // namespace tremolo
