// The order of the elements, and what changes in a problem when its mesh becomes quadratic.
#pragma once

#include "precompute/problem/problem.h"

namespace tremolo {

// Up to so many tetrahedra elements are quadratic unless the user says otherwise.
inline constexpr std::size_t kMostAutomaticQuadratic = 30'000;

// Returns 1 or 2: what the request says, or else a rule of the mesh alone: 2 for a quadratic mesh
// and for at most kMostAutomaticQuadratic tetrahedra. Lumped masses and imported bases are linear.
// Throws Failure (kUsage) if the request contradicts itself.
int choose_order(const ProblemRequest& request, const TetMesh& mesh);

// Gives the mesh the edges that its file has, straightened, or removes them for order 1; to be
// called after check_mesh and before anything is selected. Adds notes.
void prepare_edges(const ProblemRequest& request, Problem& problem);

// Makes the problem quadratic if its order is 2: adds edge points to the mesh, to its parts and to
// what is held. Called after everything has been selected; a no-op for order 1. Throws Failure
// (kContent) as the function of that name in common/mesh/edge_points.h fails.
void add_edge_points(Problem& problem);

}  // namespace tremolo
