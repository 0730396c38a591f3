// Colliders as triangles, to be seen.
#pragma once

#include <optional>
#include <string>

#include "runtime/contact/collider.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// The shape in its own frame: within a thousandth of a sphere's radius. plane: half the side of the
// square that stands for a plane, m, above 0. Nothing of a grid: it knows distances, not triangles.
std::optional<AnimatedShape> collider_shape(const Collider& collider, const std::string& name,
                                            double plane);

}  // namespace tremolo
