// Contact points of bodies of tetrahedra and cloths that the texts of a scene name.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/mixed/mixed_guests.h"

namespace tremolo {

// The contact point of a guest that a scene's `at` names. Of a body of tetrahedra: a vertex's
// number in its mesh, or a selector (common/mesh/selector.h) of one vertex of its surface, in the
// mesh's coordinates; `fixed` is a set. Of a cloth: a place of one particle, as in its pins. key,
// holder: for errors, which are kContent: a text that names no point, or several.
Result<std::size_t> guest_point(const MixedGuests& guests, std::size_t guest,
                                const std::string& text, const char* key, const char* holder);

// The same for several points, ascending: of tetrahedra also the middles of edges between vertices
// that are selected; of a cloth also selectors of particles, at their positions now. kContent: a
// text that names none.
Result<std::vector<std::size_t>> guest_points(const MixedGuests& guests, std::size_t guest,
                                              const std::string& text, const char* key);

}  // namespace tremolo
