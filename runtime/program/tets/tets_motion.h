// `tremolo export` of a scene whose [[bodies]] are of kind "tets".
#pragma once

#include <memory>

#include "runtime/program/export/motion_source.h"
#include "runtime/scene_reader/tets_reader.h"

namespace tremolo {

// The drawn surfaces are first in its recording, then, if requested, colliders as scenery. A body's
// pose is the rigid motion of its mesh's frame that fits its surface best, and its displacements
// are the difference. Errors of record: those of make_tets_bodies and frame_steps; kSolver for a
// step that fails.
std::unique_ptr<MotionSource> tets_motion(TetScene scene);

}  // namespace tremolo
