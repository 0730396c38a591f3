// Sharp edges of deformable bodies in files of other programs.
#pragma once

#include <optional>

#include "runtime/io/exchange/animation.h"

namespace tremolo {

// The animation with shapes that deform split where triangles meet at more than kCrease at rest
// (common/mesh/creases.h), as the viewer draws them: a vertex for each side, with a normal of its
// own. The given vertices are the first ones, in their order. A surface with normals of its author
// stays as it is. Empty: no shape changes. animation: has passed check_animation().
std::optional<Animation> split_creases(const Animation& animation);

}  // namespace tremolo
