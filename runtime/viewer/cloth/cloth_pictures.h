// Pictures of cloth without a display.
#pragma once

#include "runtime/viewer/cloth/cloth_scenes.h"
#include "runtime/viewer/setup/view_setup.h"

namespace tremolo {

// What a scene of bodies would say to make_setup(): gravity, and a name for each cloth and ball.
Scene names_of(const ClothScenes& scenes);

// As first_camera() and look_of(), of points and ground.
Camera camera_of_cloth(const ViewSetup& setup, const std::vector<double>& points);

// Errors: kUsage without --out and --video; those of make_setup(), of OpenGL, of files and of
// steps. The exit code is that of a signal that ended it, or 0.
Result<int> photograph_cloth(const ViewerOptions& options, ClothScenes& scenes);

}  // namespace tremolo
