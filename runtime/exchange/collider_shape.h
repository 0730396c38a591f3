// Colliders as triangles, to be seen.
#pragma once

#include <optional>
#include <string>

#include "runtime/contact/collider.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// The shape in its own frame, with an error of a thousandth of a sphere's radius. plane: half the
// side of the square that represents a plane, m, above 0. Nothing for a grid, which has distances
// instead of triangles.
std::optional<AnimatedShape> collider_shape(const Collider& collider, const std::string& name,
                                            double plane);

}  // namespace tremolo
