// The identity of a scene in a saved world: each part with a hash of its contents.
#pragma once

#include <vector>

#include "formats/saved/saved_file.h"
#include "runtime/contact/contact_law.h"
#include "runtime/model.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// Parts: the step and gravity, then bodies with their models, colliders with their shapes, hands;
// but not the duration and the outputs. models, colliders: in the scene's order. shapes: of the
// bodies, null if there is none.
std::vector<SavedPart> scene_parts(const Scene& scene, const std::vector<const Model*>& models,
                                   const std::vector<const Collider*>& shapes,
                                   std::span<const PlacedCollider> colliders);

}  // namespace tremolo
