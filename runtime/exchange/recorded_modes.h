// Motion that no modes describe -> modes of what was recorded, for formats that move vertices by
// few numbers a frame.
#pragma once

#include <cstddef>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// Each body with displacements u gets a shape of its own whose modes span what was recorded best in
// the mean square: with D = (u_1 ... u_f), the left singular vectors of D, largest singular values
// first, by the eigenvectors of D^T D (Sirovich 1987, method of snapshots). There are as few as
// keep every vertex within `enough` of the shape's size at every frame, and at most `most`. Other
// bodies stay. Returns the largest distance of all vertices and frames from where they were, over
// the size of the shape. Errors: check_animation's.
Result<double> describe_by_modes(Animation& animation, std::size_t most, double enough);

}  // namespace tremolo
