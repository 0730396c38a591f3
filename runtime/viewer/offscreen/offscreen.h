// `tremolo view --offscreen`: pictures without a display.
#pragma once

#include "runtime/viewer/live/viewed_scene.h"
#include "runtime/viewer/setup/viewer_options.h"

namespace tremolo {

// Renders the frames and writes them. The exit code; errors are printed on stderr. A body whose
// step fails stands still; the frames are all written, and the code is that of the step.
int offscreen_command(const ViewerOptions& options, const ViewedScene& viewed);

}  // namespace tremolo
