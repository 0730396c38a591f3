// Velocities of the drawn vertices of a body.
#pragma once

#include <span>

#include "common/result.h"
#include "runtime/body.h"

namespace tremolo {

// velocities: x, y, z of each drawn vertex, m/s, world. Errors kUsage: another length; a driven
// body, or one on bones, whose frame has poses instead of a velocity.
Status surface_velocities(const Body& body, std::span<double> velocities);

}  // namespace tremolo
