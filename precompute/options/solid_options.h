// Command line options that describe the solid, shared by the commands of tremolo-precompute.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "precompute/problem/problem_request.h"

namespace tremolo {

// Returns false if `flag` is followed by several numbers instead of one word X,Y,Z, whose rest
// would be taken for the mesh's name. The error has been printed then.
bool vectors_are_words(const std::vector<std::string>& words, const std::string& flag);

// Adds the options for mesh, materials, fixed vertices and loads. `texts` must stay valid until the
// line is parsed.
void add_solid_options(CLI::App& app, SolidTexts& texts);

// Parses the texts; returns the exit code if one is wrong (the error has been printed).
std::optional<int> finish_solid_options(const SolidTexts& texts, ProblemRequest& request);

// Adds the option. Since CLI11 opens the file itself, parsing throws Failure (kSystem) if it exists
// but is not a regular file, which might never end.
void add_config_option(CLI::App& app, const std::string& description);

// Returns the option's value after parsing; empty if it was not given.
std::string config_path(const CLI::App& app);

}  // namespace tremolo
