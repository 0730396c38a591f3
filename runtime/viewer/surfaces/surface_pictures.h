// Pictures of surfaces that move, without a display.
#pragma once

#include "runtime/viewer/setup/view_setup.h"
#include "runtime/viewer/surfaces/moving_surfaces.h"

namespace tremolo {

// A scene of bodies with the contents that make_setup() needs: gravity, and a name for each sheet
// and ball.
Scene names_of(const MovingSurfaces& scenes);

// The camera of first_camera(), framed on points instead of a stage.
Camera camera_of_points(const ViewSetup& setup, const std::vector<double>& points);

// Errors: kUsage without --out and --video; those of make_setup(), of OpenGL, of files and of
// steps. The exit code is that of a signal that ended it, or 0.
Result<int> photograph_surfaces(const ViewerOptions& options, MovingSurfaces& scenes);

}  // namespace tremolo
