// Surfaces in a window, where what can be held is pulled.
#pragma once

#include <string>
#include <vector>

#include "runtime/viewer/setup/view_outputs.h"
#include "runtime/viewer/setup/viewer_options.h"
#include "runtime/viewer/surfaces/moving_surfaces.h"

namespace tremolo {

// Shows the scenes until the window is closed. Left: pull, or turn where nothing can be held;
// right: turn; middle or shift: shift; wheel: nearer; space: pause; period: one step; R: from the
// beginning; F: frame; W: wires; M: the first scene's next method; [ and ]: half and twice the
// step; escape: close. Steps are made between pictures, at the pace of the clock or slower. Errors:
// no display, no OpenGL 3.3; those of make_setup(), of begin_again() and of hands that are
// recorded. The exit code: that of a signal, else that of a step that failed, else 0.
Result<int> show_surfaces(const ViewerOptions& options, MovingSurfaces& scenes);

// kUsage for flags of the viewer of bodies that this one does not have. kind: of what is shown.
Status refuse_body_flags(const ViewerOptions& options, const std::string& kind);

// show_surfaces(), or with --offscreen photograph_surfaces(). inputs: the scenes' files. Errors:
// also those of check_view_outputs().
Result<int> view_surfaces(const ViewerOptions& options, const std::vector<NamedFile>& inputs,
                          MovingSurfaces& scenes);

}  // namespace tremolo
