// The identity of a scene in a saved world: each part with a hash of its contents.
#pragma once

#include <vector>

#include "formats/saved/saved_file.h"
#include "runtime/contact/contact_law.h"
#include "runtime/model.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The step and gravity, then bodies with their models, colliders with their shapes, hands. How long
// a run is and what it writes is not among it. models, colliders: in the scene's order. shapes: of
// the bodies, null where there is none.
std::vector<SavedPart> scene_parts(const Scene& scene, const std::vector<const Model*>& models,
                                   const std::vector<const Collider*>& shapes,
                                   std::span<const PlacedCollider> colliders);

}  // namespace tremolo
