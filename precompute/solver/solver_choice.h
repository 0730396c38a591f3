// Who solves with the stiffness: chosen before anything large is allocated.
#pragma once

#include <optional>
#include <string>

#include "precompute/fem/dof_map.h"

namespace tremolo {

// kCholmod: a factor in one process's memory. kMumps: a factor spread over the ranks. kIterative:
// no factor, multigrid.
enum class LinearSolver { kCholmod, kMumps, kIterative };
const char* name_of(LinearSolver solver);

// What the largest arrays of a run will take, bytes on the rank that needs most, from counting
// entries and columns; the stages' own peaks, which are measured, lie some 10 % around it.
struct MemoryEstimate {
  double matrices = 0;  // M and K
  double factor = 0;    // with what its making takes
  double multigrid = 0;
  double columns = 0;            // modes, derivatives, basis, of the rank's own rows
  double iterative_columns = 0;  // the same where LOBPCG finds the modes
  double rest = 0;               // the mesh with its graph, the program
  double direct() const { return matrices + factor + columns + rest; }
  double iterative() const { return matrices + multigrid + iterative_columns + rest; }
};

struct SolverRequest {
  std::optional<LinearSolver> solver;  // what the user asked for
  std::optional<double> memory;        // bytes a rank may use; none: what the machine has free
  int linear_modes = 0;
  int modes = 0;
  bool derivatives = true;
  int rigid_modes = 0;  // of a free body
  unsigned threads = 1;
};

struct SolverChoice {
  LinearSolver solver = LinearSolver::kCholmod;
  MemoryEstimate estimate;
  double available = 0;  // bytes a rank may use
  std::string reason;    // for the user, one line
};

// Bytes that this process may take in all, what it has included: its share, among `ranks_here` of
// one machine, of the memory that is free there or that the limits of its control groups leave.
double available_memory(int ranks_here);

// Cholesky factor of the nodes' 3x3 blocks in the map's order, entries, by symbolic analysis; on
// several ranks in a nested dissection of the whole. Deterministic.
double count_factor_entries(const DofMap& map);

// The factor where it fits, else multigrid; what the user asked for in any case, with a warning in
// `reason` when it may not fit. Throws Failure: kSystem when neither fits, naming what would,
// kUsage for CHOLMOD on several ranks. All ranks together; they all get the same answer.
SolverChoice choose_solver(const DofMap& map, const LocalDofs& local, const SolverRequest& request);

}  // namespace tremolo
