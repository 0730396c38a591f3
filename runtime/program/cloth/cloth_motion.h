// `tremolo export` of a scene with [[cloths]].
#pragma once

#include <memory>
#include <vector>

#include "runtime/program/export/motion_source.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Scenes, at least one, each to the right of the previous one; a name that exists already gets "-2"
// appended. Cloths of a scene are first in its recording, then balls and, if requested, colliders
// as scenery, planes of the first scene only. Errors of record: those of ClothWorld::create and
// step, and of frame_steps; kContent if the frames of the scenes have different times.
std::unique_ptr<MotionSource> cloth_motion(std::vector<ClothFile> files);

}  // namespace tremolo
