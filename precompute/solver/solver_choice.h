// Choice of the solver for the stiffness, made before anything large is allocated.
#pragma once

#include <optional>
#include <string>

#include "precompute/fem/dof_map.h"

namespace tremolo {

// kCholmod: a factor in one process's memory. kMumps: a factor distributed over the ranks.
// kIterative: multigrid without a factor.
enum class LinearSolver { kCholmod, kMumps, kIterative };
const char* name_of(LinearSolver solver);

// Estimated bytes of the largest arrays of a run, on the rank that needs most, from counts of
// entries and columns. Measured peaks of the stages lie within about 10 %.
struct MemoryEstimate {
  double matrices = 0;  // M and K
  double factor = 0;    // including its workspace
  double multigrid = 0;
  double columns = 0;            // modes, derivatives and basis, the rank's own rows
  double iterative_columns = 0;  // the same if LOBPCG computes the modes
  double rest = 0;               // the mesh with its graph, the program
  double direct() const { return matrices + factor + columns + rest; }
  double iterative() const { return matrices + multigrid + iterative_columns + rest; }
};

struct SolverRequest {
  std::optional<LinearSolver> solver;  // explicit request; none: automatic
  std::optional<double> memory;        // bytes a rank may use; none: the free memory
  int linear_modes = 0;
  int modes = 0;
  bool derivatives = true;
  int rigid_modes = 0;  // of a free body
  int order = 1;        // of the elements: what a refusal advises
  unsigned threads = 1;
};

struct SolverChoice {
  LinearSolver solver = LinearSolver::kCholmod;
  MemoryEstimate estimate;
  double available = 0;  // bytes a rank may use
  std::string reason;    // one line for the user
};

// Returns the bytes that this process may use in total, including those it uses now: its share,
// among `ranks_here` on one machine, of the free memory or of what the limits of its cgroups leave.
double available_memory(int ranks_here);

// Returns the number of entries of the Cholesky factor for the nodes' 3x3 blocks, by symbolic
// analysis in the map's order; on several ranks in a nested dissection of the whole graph.
// Deterministic.
double count_factor_entries(const DofMap& map);

// Returns a solver with a factor if it fits, else multigrid. An explicit request is always
// followed, with a warning in `reason` if it may not fit. Throws Failure: kSystem if neither fits,
// with a remedy in the message; kUsage for CHOLMOD on several ranks. Collective; the same result on
// all ranks.
SolverChoice choose_solver(const DofMap& map, const LocalDofs& local, const SolverRequest& request);

}  // namespace tremolo
