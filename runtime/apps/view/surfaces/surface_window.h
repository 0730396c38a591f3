// Moving surfaces in a window, where particles and vertices can be pulled.
#pragma once

#include <string>
#include <vector>

#include "runtime/apps/view/setup/view_setup.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"

namespace tremolo {

// Shows the scenes until the window is closed. Left button: pull, or rotate where nothing can be
// grabbed; right: rotate; middle or shift: move; wheel: zoom; space: pause; period: one step; R:
// restart; F: frame; W: wires; M: the first scene's next method; [ and ]: half and twice the step;
// escape: close. Steps are made between pictures, at the pace of the clock or slower. Errors: no
// display, no OpenGL 3.3; those of make_setup(), of begin_again() and of recorded hands. Returns
// the exit code: that of a signal, else that of a failed step, else 0.
Result<int> show_surfaces(const ViewerOptions& options, MovingSurfaces& scenes);

// kUsage for flags of the viewer of bodies that this one does not support. kind: of the scene.
Status refuse_body_flags(const ViewerOptions& options, const std::string& kind);

// show_surfaces(), or with --offscreen photograph_surfaces(). inputs: the scenes' files. Errors:
// also those of check_view_outputs().
Result<int> view_surfaces(const ViewerOptions& options, const std::vector<NamedFile>& inputs,
                          MovingSurfaces& scenes);

// A scene of bodies with the contents that make_setup() needs: gravity, and a name for each sheet
// and ball.
Scene names_of(const MovingSurfaces& scenes);

// True if the stress of at least one triangle of the sheets can be computed.
bool has_materials(const MovingSurfaces& scenes);

// The camera of first_camera(), framed on points instead of a stage.
Camera camera_of_points(const ViewSetup& setup, const std::vector<double>& points);

// Errors: kUsage without --out and --video; those of make_setup(), of OpenGL, of files and of
// steps. The exit code is that of a signal that ended it, or 0.
Result<int> photograph_surfaces(const ViewerOptions& options, MovingSurfaces& scenes);

}  // namespace tremolo
