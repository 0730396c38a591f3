// The order of the elements, and what changes in a problem when its mesh becomes quadratic or is
// refined.
#pragma once

#include "precompute/problem/problem.h"

namespace tremolo {

// Up to so many tetrahedra elements are quadratic unless the user says otherwise.
inline constexpr std::size_t kMostAutomaticQuadratic = 30'000;

// Returns 1 or 2: what the request says, or else a rule of the mesh alone: 2 for a quadratic mesh
// and for at most kMostAutomaticQuadratic tetrahedra, refined ones counted. Lumped masses and
// imported bases are linear. prepare_edges() makes a larger mesh quadratic too if a wall of it has
// one layer of elements. Throws Failure (kUsage) if the request contradicts itself.
int choose_order(const ElementRequest& request, bool imported, const TetMesh& mesh);

// Gives the mesh the edges that its file has, straightened, or removes them for order 1; to be
// called after check_mesh and before anything is selected. Adds notes.
void prepare_edges(const ProblemRequest& request, Problem& problem);

// Makes the problem quadratic if its order is 2: adds edge points to the mesh, to its parts and to
// what is held. Called after everything has been selected; a no-op for order 1. Throws Failure
// (kContent) as the function of that name in common/mesh/edge_points.h fails.
void add_edge_points(Problem& problem);

// Returns the same body on a mesh of eight times as many tetrahedra, of the same order. The points
// of `problem`'s quadratic mesh (edge points included, whatever its order) are the first corners of
// the result's, with the same numbers. What holds, loads and weighs it is the same: an edge's
// middle is held as elements of order 2 hold it. A render surface is left out. Throws Failure
// (kContent) if there would be too many vertices.
Problem refined_problem(const Problem& problem);

// Replaces the problem's mesh `times` times by that of refined_problem(), with what holds it and
// its materials; a render surface hangs on the new tetrahedra. Called after add_edge_points. Adds a
// note. Throws Failure as refined_problem() does.
void refine(int times, unsigned threads, Problem& problem);

}  // namespace tremolo
