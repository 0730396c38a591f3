// Runs a scene with [[cloths]] and records what it does.
#pragma once

#include "common/result.h"
#include "runtime/program/export/animate.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Cloths come first, then balls and, if asked for, colliders as scenery. Errors: those of
// ClothWorld::create and step, and of frame_steps.
Result<RecordedMotion> animate_cloths(const ClothFile& file, const FrameRange& range,
                                      bool colliders);

}  // namespace tremolo
