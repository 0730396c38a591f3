// Loads of a scene on bodies of tetrahedra and cloths.
#pragma once

#include <span>

#include "common/result.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// Gives a guest its loads: they begin at its time 0. Errors, with the body's name: those of
// guest_pushes() and MixedGuests::add_load(); kContent: without `at`, since the guest's file has no
// load of its own.
Status add_guest_loads(MixedGuests& guests, std::size_t guest, std::span<const SceneLoad> loads);

}  // namespace tremolo
