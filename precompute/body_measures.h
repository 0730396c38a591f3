// Numbers that describe the whole body before anything is solved.
#pragma once

#include <string>
#include <vector>

#include "precompute/fem/stvk.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// kg, point masses included.
double total_mass(const Problem& problem);

// The diagonal of the box around what vibrates, m: vertices of no tetrahedron may lie anywhere.
double body_size(const Problem& problem);

// A negative shift of the pencil, (rad/s)^2, far below the first elastic mode of a compact body: it
// makes a free body's singular K definite. Of several materials the softest and the densest count,
// and point masses as if the densest carried them.
double small_shift(const Problem& problem, const Solid& solid);

// For the user: what the parts of a body of several materials weigh, point masses, and stiffnesses
// too far apart for double precision. One material is what was asked for: nothing.
std::vector<std::string> material_notes(const Problem& problem, const Solid& solid);

}  // namespace tremolo
