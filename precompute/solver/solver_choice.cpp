#include "precompute/solver/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <suitesparse/cholmod.h>

#include "common/packed_index.h"
#include "common/text.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// Returns the first number of a file, or of its line that starts with `key`; none if it is missing.
std::optional<double> number_in(const std::string& path, const std::string& key = "") {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    try {
      return std::stod(line.substr(key.size()));
    } catch (const std::exception&) {
      return std::nullopt;  // "max": no limit
    }
  }
  return std::nullopt;
}

// File names of one cgroup version. cache: reclaimable part of the used memory.
struct ControlGroupFiles {
  std::string root, limit, used, cache;
};
const ControlGroupFiles kUnified{"/sys/fs/cgroup", "/memory.max", "/memory.current",
                                 "inactive_file "};
const ControlGroupFiles kMemoryOnly{"/sys/fs/cgroup/memory", "/memory.limit_in_bytes",
                                    "/memory.usage_in_bytes", "total_inactive_file "};

// Returns the bytes left in the group `path` and its ancestors; infinite without a limit.
double rest_of_group(const ControlGroupFiles& files, std::string path) {
  double rest = std::numeric_limits<double>::infinity();
  for (;; path.resize(path.find_last_of('/'))) {
    const std::string folder = files.root + path;
    const auto most = number_in(folder + files.limit), now = number_in(folder + files.used);
    const double cache = number_in(folder + "/memory.stat", files.cache).value_or(0);
    if (most && now) rest = std::min(rest, std::max(0.0, *most - (*now - cache)));
    if (path.find('/') == std::string::npos) return rest;
  }
}

// Returns the bytes left in this process's groups, from lines "0::/path" and "NUMBER:memory:/path".
// Inside a container the path may be the host's, so the root group is always checked.
double control_group_rest() {
  double rest = std::min(rest_of_group(kUnified, ""), rest_of_group(kMemoryOnly, ""));
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const std::size_t path = line.find(":/");
    if (path == std::string::npos || line.size() == path + 2) continue;
    if (line.starts_with("0::"))
      rest = std::min(rest, rest_of_group(kUnified, line.substr(path + 1)));
    else if (line.find(":memory:") != std::string::npos)
      rest = std::min(rest, rest_of_group(kMemoryOnly, line.substr(path + 1)));
  }
  return rest;
}

int ranks_on_this_machine() {
  MPI_Comm here = MPI_COMM_NULL;
  int ranks = 1;
  MPI_Comm_split_type(PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
  MPI_Comm_size(here, &ranks);
  MPI_Comm_free(&here);
  return ranks;
}

constexpr double kNumber = 8;
constexpr double kEntry = 12;  // of a sparse matrix: a value and a column index

// cholmod: whether CHOLMOD would factorise, else MUMPS.
MemoryEstimate estimate(const DofMap& map, const LocalDofs& local, const SolverRequest& request,
                        double factor_entries, bool cholmod) {
  MemoryEstimate bytes;
  const double ranks = mpi_ranks();
  const double blocks = map.graph.start[local.first_node + local.nodes] -
                        map.graph.start[local.first_node] + local.nodes;
  const double stiffness = 9 * kEntry * blocks;
  bytes.matrices = (1.0 + 1.0 / 3.0) * stiffness;
  // CHOLMOD copies the matrix, and a shift copies it again; MUMPS gathers triplets and keeps a
  // stack of frontal matrices beside the factor.
  bytes.factor = cholmod
                     ? kNumber * factor_entries + (request.rigid_modes > 0 ? 2.0 : 1.0) * stiffness
                     : 1.6 * kNumber * factor_entries / ranks + 1.5 * stiffness;
  bytes.multigrid = 2.2 * stiffness;  // coarser grids and prolongations, measured
  const double k = request.linear_modes, column = kNumber * local.dofs();
  const double derivatives =
      request.derivatives ? static_cast<double>(pair_count(request.linear_modes)) : 0.0;
  const double rigid = 3.0 * request.rigid_modes;  // the motions, M times them, and temporaries
  const double while_modes = 8.0 * k + 100.0;
  const double while_iterating = 15.0 * (k + 2.0);  // LOBPCG's blocks
  const double while_derivatives = 2.0 * k + derivatives + 4.0 * 28.0 * request.threads;
  const double while_basis = k + derivatives + request.modes + 64.0;
  bytes.columns = column * (rigid + std::max({while_modes, while_derivatives, while_basis}));
  bytes.iterative_columns =
      column * (rigid + std::max({while_iterating, while_derivatives, while_basis}));
  const double strain_columns = request.modes + static_cast<double>(pair_count(request.modes));
  bytes.rest = 60e6 + 136.0 * static_cast<double>(local.tetrahedra.size()) +
               120.0 * static_cast<double>(map.node_of_vertex.size()) +
               12.0 * static_cast<double>(map.graph.neighbours.size()) +
               (request.derivatives ? 8.0 * kNumber * strain_columns * strain_columns : 0.0);
  return bytes;
}

std::string in_gigabytes(double bytes) {
  return text("%.3g GB", 1e-9 * bytes);
}

std::string allowance(const SolverRequest& request, const SolverChoice& choice) {
  return in_gigabytes(choice.available) +
         (request.memory ? " are allowed by --memory" : " are free");
}

// Returns the largest number of linear modes that would fit without a factor; 0 if not even one
// would.
int modes_that_fit(const DofMap& map, const LocalDofs& local, SolverRequest request,
                   double available) {
  for (; request.linear_modes > 0; --request.linear_modes) {
    const double need = over_ranks(estimate(map, local, request, 0, false).iterative(), MPI_MAX);
    if (need <= available) break;
  }
  return request.linear_modes;
}

// Rounds a count to two digits for messages.
double rounded(double count) {
  const double digit = std::pow(10.0, std::floor(std::log10(count)) - 1.0);
  return digit < 1.0 ? std::round(count) : digit * std::round(count / digit);
}

[[noreturn]] void refuse(const DofMap& map, const LocalDofs& local, const SolverRequest& request,
                         const SolverChoice& choice) {
  const int fewer = modes_that_fit(map, local, request, choice.available);
  std::string cure = fewer > 0 ? text("--linear-modes %d would fit; or take more ranks", fewer)
                               : std::string("Take more ranks");
  // The memory grows with the number of elements; without a factor, at most in proportion.
  const double fit = choice.available / choice.estimate.iterative() *
                     static_cast<double>(local.tetrahedra.size() * mpi_ranks());
  if (request.order == 2 && fit >= 1)
    cure = text("About %.0f quadratic tetrahedra would fit, or linear ones, --order 1. ",
                rounded(fit)) +
           cure;
  throw Failure(
      system_error("not enough memory: " + in_gigabytes(choice.estimate.direct()) +
                   " a rank with a factor, " + in_gigabytes(choice.estimate.iterative()) +
                   " without one, but " + allowance(request, choice) + ". " + cure +
                   " on more machines, or a coarser mesh; --memory or --solver overrule this"));
}

}  // namespace

const char* name_of(LinearSolver solver) {
  switch (solver) {
    case LinearSolver::kCholmod:
      return "cholmod";
    case LinearSolver::kMumps:
      return "mumps";
    case LinearSolver::kIterative:
      return "iterative";
  }
  return "";
}

double available_memory(int ranks_here) {
  double free = number_in("/proc/meminfo", "MemAvailable:").value_or(1e300 / 1024.0) * 1024.0;
  free = std::min(free, control_group_rest());
  const double taken = number_in("/proc/self/status", "VmRSS:").value_or(0) * 1024.0;
  return free / ranks_here + taken;
}

double count_factor_entries(const DofMap& map) {
  const std::size_t nodes = map.nodes();
  std::vector<int> order(nodes);
  if (map.rank_begin.size() == 2)
    std::iota(order.begin(), order.end(), 0);
  else
    order = dissection_order(map.graph);
  cholmod_common common = {};
  cholmod_start(&common);
  common.print = 0;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SUPERNODAL;
  // CHOLMOD merges small supernodes by their number of columns; here a node stands for three
  // columns.
  common.nrelax[0] /= 3;
  common.nrelax[1] /= 3;
  common.nrelax[2] /= 3;
  cholmod_sparse pattern = {};
  pattern.nrow = pattern.ncol = nodes;
  pattern.nzmax = map.graph.neighbours.size();
  pattern.p = const_cast<int*>(map.graph.start.data());
  pattern.i = const_cast<int*>(map.graph.neighbours.data());
  pattern.stype = 1;
  pattern.itype = CHOLMOD_INT;
  pattern.xtype = CHOLMOD_PATTERN;
  pattern.dtype = CHOLMOD_DOUBLE;
  pattern.sorted = 1;
  pattern.packed = 1;
  cholmod_factor* factor = cholmod_analyze_p(&pattern, order.data(), nullptr, 0, &common);
  const double entries = factor == nullptr ? std::numeric_limits<double>::infinity()
                                           : 9.0 * static_cast<double>(factor->xsize);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  return entries;
}

SolverChoice choose_solver(const DofMap& map, const LocalDofs& local,
                           const SolverRequest& request) {
  SolverChoice choice;
  double entries = mpi_rank() == 0 ? count_factor_entries(map) : 0.0;
  entries = over_ranks(entries, MPI_MAX);
  // CHOLMOD counts entries in 32 bits, and this estimate may be off: near the limit it is still
  // tried.
  constexpr double kMostEntries = 2147483648.0, kMargin = 1.25;
  const bool fits_cholmod = mpi_ranks() == 1 && entries < kMostEntries;
  const bool cholmod =
      request.solver ? *request.solver != LinearSolver::kMumps && mpi_ranks() == 1 : fits_cholmod;
  MemoryEstimate worst = estimate(map, local, request, entries, cholmod);
  for (double MemoryEstimate::*part :
       {&MemoryEstimate::matrices, &MemoryEstimate::factor, &MemoryEstimate::multigrid,
        &MemoryEstimate::columns, &MemoryEstimate::iterative_columns, &MemoryEstimate::rest})
    worst.*part = over_ranks(worst.*part, MPI_MAX);
  choice.estimate = worst;
  choice.available = request.memory
                         ? *request.memory
                         : 0.9 * over_ranks(available_memory(ranks_on_this_machine()), MPI_MIN);
  const bool direct_fits = worst.direct() <= choice.available;
  if (request.solver)
    choice.solver = *request.solver;
  else if (direct_fits)
    choice.solver = fits_cholmod ? LinearSolver::kCholmod : LinearSolver::kMumps;
  else if (worst.iterative() <= choice.available)
    choice.solver = LinearSolver::kIterative;
  else
    refuse(map, local, request, choice);
  if (choice.solver == LinearSolver::kCholmod && mpi_ranks() > 1)
    throw Failure({ErrorKind::kUsage,
                   "--solver cholmod factorises in one process: on several "
                   "ranks ask for mumps or iterative"});
  if (choice.solver == LinearSolver::kCholmod && entries > kMargin * kMostEntries)
    throw Failure({ErrorKind::kUsage,
                   "--solver cholmod counts at most 2^31 entries of a factor, "
                   "this one has about " +
                       text("%.3g", entries) + ": ask for mumps"});
  const double need =
      choice.solver == LinearSolver::kIterative ? worst.iterative() : worst.direct();
  choice.reason = std::string(name_of(choice.solver)) + ": estimated " +
                  in_gigabytes(worst.direct()) + " a rank with a factor of " +
                  text("%.3g", entries) + " entries, " + in_gigabytes(worst.iterative()) +
                  " without; " + allowance(request, choice);
  if (need > choice.available) choice.reason += ": MEMORY MAY RUN OUT";
  return choice;
}

}  // namespace tremolo
