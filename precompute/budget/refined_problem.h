// The same body on a mesh of eight times as many tetrahedra, of the same order.
#pragma once

#include "precompute/problem/problem.h"

namespace tremolo {

// The points of `problem`'s quadratic mesh (edge points included, whatever its order) are the first
// corners of the result's, with the same numbers. What holds, loads and weighs it is the same: an
// edge's middle is held as elements of order 2 hold it. A render surface is left out. Throws
// Failure (kContent) if there would be too many vertices.
Problem refined_problem(const Problem& problem);

}  // namespace tremolo
