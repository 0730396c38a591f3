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
// what is held. Called after everything has been selected; a no-op for order 1. by_place, along:
// vertices that selectors chose by where they lie (held_edge_points), of all axes and of one.
void add_edge_points(const std::vector<VertexId>& by_place,
                     const std::array<std::vector<VertexId>, 3>& along, Problem& problem);

}  // namespace tremolo
