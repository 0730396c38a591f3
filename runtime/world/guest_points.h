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

// A force on what a load's `at` names, N: a number or a selection as for guest_points(), without
// middles of edges. Of tetrahedra it is distributed as area_shares() does (surface_mesh.h), of a
// cloth by the area for which each particle stands. kContent: a text that names none; no point
// there moves, or the force is zero.
Result<std::vector<PointPush>> guest_pushes(const MixedGuests& guests, std::size_t guest,
                                            const std::string& text, const Eigen::Vector3d& force);

}  // namespace tremolo
