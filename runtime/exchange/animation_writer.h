// An animation in the format that a path's ending names.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"
#include "runtime/exchange/point_cache.h"

namespace tremolo {

// .glb, .usda, .pvd, .pc2 or .mdd, each as its writer writes without options; .ply or .obj: a
// numbered series. All files that were written. Errors: kUsage for another ending; the writers'.
Result<std::vector<WrittenFile>> write_animation(const std::string& path,
                                                 const Animation& animation);

}  // namespace tremolo
