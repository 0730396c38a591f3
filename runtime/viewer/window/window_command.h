// `tremolo view`: the window.
#pragma once

#include "runtime/viewer/live/viewed_scene.h"
#include "runtime/viewer/setup/viewer_options.h"

namespace tremolo {

// Shows the scene until the window is closed. The exit code; errors are printed on stderr.
int window_command(const ViewerOptions& options, const ViewedScene& viewed);

}  // namespace tremolo
