// Hands and joints of a scene on bodies of tetrahedra and cloths.
#pragma once

#include <memory>
#include <string>

#include "common/result.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/scene/scene_links.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// The contact point of a guest that a scene's `at` names. Of a body of tetrahedra: a vertex's
// number in its mesh, or a selector (common/mesh/selector.h) of one vertex of its surface, in the
// mesh's coordinates; `fixed` is a set. Of a cloth: a place of one particle, as in its pins. key,
// holder: for errors, which are kContent: a text that names no point, or several.
Result<std::size_t> guest_point(const MixedGuests& guests, std::size_t guest,
                                const std::string& text, const char* key, const char* holder);

// Makes the hands and the joints of the world's scene that hold one of its guests, and joins those.
// world, guests: stay in memory. Errors (kContent), with the hand or joint: those of guest_point()
// and as for MovingHand::create() and HeldJoint::create().
Result<std::unique_ptr<GuestLinks>> make_guest_links(const SceneWorld& world, MixedGuests& guests);

}  // namespace tremolo
