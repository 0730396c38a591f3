// Checks, before a view begins, that its outputs are not among its inputs.
#pragma once

#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/viewer/setup/viewer_options.h"

namespace tremolo {

// All files that the view reads: those of the scene, and pictures of --texture.
std::vector<NamedFile> inputs_of_view(const ViewerOptions& options,
                                      std::vector<NamedFile> of_scene);

// Checks the existing pictures in --out, the film and the recorded hand. Errors: kUsage if one of
// them is an input or another of them, or for flags that exclude each other; kSystem if one cannot
// be written.
Status check_view_outputs(const ViewerOptions& options, const std::vector<NamedFile>& inputs);

}  // namespace tremolo
