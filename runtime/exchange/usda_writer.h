// An animation as one .usda file: USD's text form.
#pragma once

#include <string>

#include "common/result.h"
#include "runtime/exchange/animation.h"
#include "runtime/exchange/point_cache.h"

namespace tremolo {

// A stage in metres, its up axis z (z_up) or y, with an Xform `tremolo` and a Mesh for each body:
// `points` in the body's frame as time samples, floats of nine digits; `xformOp:translate` and
// `xformOp:orient` as time samples, or constant if the body is at rest. Points of a body on bones
// are in the world, without a pose. timeCodesPerSecond is Animation::rate, and a frame's time code
// its time, s, times that: exact, not rounded to whole codes. Texture coordinates are primvars:st,
// colours primvars:displayColor; materials become GeomSubsets without shaders. A body's name
// becomes an identifier: characters other than letters, digits and '_' become '_'. Errors: those of
// check_animation; kSystem.
Result<WrittenFile> write_usda(const std::string& path, const Animation& animation,
                               bool z_up = true);

}  // namespace tremolo
