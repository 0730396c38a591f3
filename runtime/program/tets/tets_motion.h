// `tremolo export` of a scene whose [[bodies]] are of kind "tets".
#pragma once

#include <memory>

#include "runtime/program/export/motion_source.h"
#include "runtime/scene_reader/tets_reader.h"

namespace tremolo {

// The drawn surfaces come first in its recording, then, if asked for, colliders as scenery. A
// body's pose is the motion of its mesh's frame that comes nearest to that of its surface, and its
// displacements are what is left. Errors of record: those of make_tets_bodies and frame_steps;
// kSolver for a step that could not be made.
std::unique_ptr<MotionSource> tets_motion(TetScene scene);

}  // namespace tremolo
