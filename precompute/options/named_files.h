// The files that a command line of tremolo-precompute names.
#pragma once

#include <string>
#include <vector>

#include "formats/file/output_guard.h"
#include "precompute/problem/problem_request.h"

namespace tremolo {

// All that is read of a solid: mesh, --render, and the lists of ids of all selectors. config_path:
// of --config, may be empty.
std::vector<NamedFile> input_files(const ProblemRequest& request, const std::string& config_path);

// Adds the lists of ids that a selector (or, for a probe, a vertex id) names.
void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files);

}  // namespace tremolo
