// Parts of a run's report and files that all kinds of guests of a world have: bodies of tetrahedra
// and cloths.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/mixed/mixed_guests.h"

namespace tremolo {

// Adds the contacts of a guest. h: the step, s.
void add_guest_contacts(const MixedGuests& guests, std::size_t guest, double h,
                        nlohmann::ordered_json& json);

// Columns of a guest's hands and joints: their energies, J, and the force of all hands, N.
inline constexpr const char* kHeldColumns = ",hand,joint,hand_fx,hand_fy,hand_fz";
std::array<double, 5> held_values(const MixedGuests& guests, std::size_t guest);

// Names of bodies of tetrahedra, then of cloths.
std::vector<std::string> guest_names(const MixedFile& mixed);

}  // namespace tremolo
