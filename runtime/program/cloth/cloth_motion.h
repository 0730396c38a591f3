// `tremolo export` of a scene with [[cloths]].
#pragma once

#include <memory>
#include <vector>

#include "runtime/program/export/motion_source.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Scenes, at least one, each to the right of the one before; a name that is taken gets "-2" behind
// it. Cloths of a scene come first in its recording, then balls and, if asked for, colliders as
// scenery, planes of the first scene only. Errors of record: those of ClothWorld::create and step,
// and of frame_steps; kContent where the scenes' frames have other times.
std::unique_ptr<MotionSource> cloth_motion(std::vector<ClothFile> files);

}  // namespace tremolo
