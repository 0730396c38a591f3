// `tremolo export` of a scene with [[cloths]].
#pragma once

#include <memory>

#include "runtime/program/export/motion_source.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Cloths come first in its recording, then balls and, if asked for, colliders as scenery. Errors of
// record: those of ClothWorld::create and step, and of frame_steps.
std::unique_ptr<MotionSource> cloth_motion(ClothFile file);

}  // namespace tremolo
