// `tremolo view --offscreen`: pictures without a display.
#pragma once

#include "runtime/viewer/live/viewed_scene.h"
#include "runtime/viewer/setup/viewer_options.h"

namespace tremolo {

// Renders the frames and writes them. Returns the exit code; errors are printed on stderr. A body
// whose step fails stays at rest; all frames are still written, and the exit code is that of the
// step.
int offscreen_command(const ViewerOptions& options, const ViewedScene& viewed);

}  // namespace tremolo
