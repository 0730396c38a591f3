// Computes modes for a recorded motion without any, for formats that move vertices by few numbers
// per frame.
#pragma once

#include <cstddef>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// Gives each body with displacements u a shape of its own whose modes are optimal for the recording
// in the mean square: with D = (u_1 ... u_f), the left singular vectors of D, largest singular
// values first, by the eigenvectors of D^T D (Sirovich 1987, method of snapshots). Their number is
// the smallest for which every vertex is within `enough` of the shape's size at every frame, and at
// most `most`. Other bodies stay. Returns the largest error over all vertices and frames, relative
// to the size of the shape. Errors: check_animation's.
Result<double> describe_by_modes(Animation& animation, std::size_t most, double enough);

}  // namespace tremolo
