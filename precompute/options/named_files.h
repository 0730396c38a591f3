// Files named on the command line of tremolo-precompute.
#pragma once

#include <string>
#include <vector>

#include "formats/file/output_guard.h"
#include "precompute/problem/problem_request.h"

namespace tremolo {

// Returns all input files of a solid: mesh, --render, and the id lists in selectors. config_path:
// value of --config, may be empty.
std::vector<NamedFile> input_files(const ProblemRequest& request, const std::string& config_path);

// Adds the id lists that a selector (or, for a probe, a vertex id) names.
void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files);

}  // namespace tremolo
