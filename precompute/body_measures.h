// Quantities of the whole body that are known before solving.
#pragma once

#include <string>
#include <vector>

#include "precompute/fem/stvk.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Returns the mass with point masses, kg.
double total_mass(const Problem& problem);

// Returns the diagonal of the bounding box, m, over vertices of tetrahedra; others are ignored.
double body_size(const Problem& problem);

// Returns a negative shift of the pencil, (rad/s)^2, far below the first elastic mode of a compact
// body, which makes a free body's singular K definite. It uses the softest and the densest
// material, and treats point masses as extra density of the latter.
double small_shift(const Problem& problem, const Solid& solid);

// Returns notes for the user: share and mass of each material if there are several, point masses,
// and stiffnesses that differ too much for double precision.
std::vector<std::string> material_notes(const Problem& problem, const Solid& solid);

}  // namespace tremolo
