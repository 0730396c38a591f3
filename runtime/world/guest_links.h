// Hands and joints of a scene on bodies of tetrahedra and cloths.
#pragma once

#include <memory>

#include "common/result.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/scene/scene_links.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Makes the hands and the joints of the world's scene that hold one of its guests, and joins those.
// world, guests: stay in memory. Errors (kContent), with the hand or joint: those of guest_point()
// and as for MovingHand::create() and HeldJoint::create().
Result<std::unique_ptr<GuestLinks>> make_guest_links(const SceneWorld& world, MixedGuests& guests);

}  // namespace tremolo
