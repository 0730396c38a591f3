// The files that a command line of tremolo-precompute names.
#pragma once

#include <string>
#include <vector>

#include "formats/file/output_guard.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// All that is read: mesh, --config, --render, --import-basis, --import-cubic, and the lists of ids
// of all selectors.
std::vector<NamedFile> input_files(const PrecomputeOptions& options);

// Adds the lists of ids that a selector (or, for a probe, a vertex id) names.
void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files);

}  // namespace tremolo
