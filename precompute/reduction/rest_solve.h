// Many solves of K X = B on the factor that the modes left, as modal derivatives need them.
#pragma once

#include <functional>

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

// Subtracts or adds the right-hand sides `first` .. `first + loads.cols()` - 1 to `loads`, local
// dofs x width, which is zero. Called from several threads where they may share the solver.
using FillLoads = std::function<void(Eigen::Index first, Columns& loads)>;

// Solves for solutions.cols() right-hand sides, `block` columns at a time; with CHOLMOD as many
// blocks at a time as there are threads, so that only those exist twice. solver: prepared. Returns
// the largest |K X - B| / |B| (a right-hand side that is nearly zero counts as the largest). If the
// body has rigid motions, K is singular: the right-hand side is made self-balancing, an iteration
// with the factor of K + sM converges to the solution on the complement of the motions, and X has
// no component along them. Throws Failure (kSolver) if the iteration does not converge. Collective.
double solve_at_rest(const Pencil& pencil, const ShiftedSolver& solver, Eigen::Index block,
                     const FillLoads& fill, ColumnsOut solutions);

}  // namespace tremolo
