// Cloth in a window, where a particle can be pulled.
#pragma once

#include "runtime/viewer/cloth/cloth_scenes.h"
#include "runtime/viewer/setup/viewer_options.h"

namespace tremolo {

// Shows the scenes until the window is closed. Left: pull a particle, or turn where there is none;
// right: turn; middle or shift: shift; wheel: nearer; space: pause; period: one step; R: from the
// beginning; F: frame; W: wires; escape: close. Steps are made between pictures, at the pace of the
// clock or slower. Errors: no display, no OpenGL 3.3; those of make_setup() and of begin_again().
// The exit code: that of a signal, else that of a step that failed, else 0.
Result<int> show_cloth(const ViewerOptions& options, ClothScenes& scenes);

// `tremolo view` of scenes with [[cloths]], with or without --offscreen; errors are printed.
int view_cloth_command(const ViewerOptions& options, const ViewFlags& flags);

}  // namespace tremolo
