#include "precompute/problem/precompute_request.h"

#include <algorithm>
#include <limits>

#include "common/packed_index.h"
#include "common/text.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

constexpr int kDefaultModes = 30, kMostDefaultLinear = 20;

// Rejects --error-budget where it cannot be measured.
void require_measurable(const OutputRequest& output, const std::optional<LoadRequest>& load) {
  if (!output.error_budget) return;
  if (mpi_ranks() > 1)
    throw Failure(
        {ErrorKind::kUsage, "--error-budget works in one process: start it without mpiexec"});
  if (!load)
    throw Failure(content_error(
        "--error-budget is measured under the default load: give --load-at and --load-force"));
}

// Rejects --target-error where it cannot be reached.
void require_reachable(const BasisRequest& basis, const std::optional<LoadRequest>& load) {
  if (!basis.target_error) return;
  const double target = *basis.target_error;
  if (!(target > 0 && target < 1))
    throw Failure(content_error(text("--target-error %g: must be between 0 and 1", target)));
  if (!load)
    throw Failure(content_error(
        "--target-error is measured under the default load: give --load-at and --load-force"));
  if (basis.linear_modes.value_or(0) > kMostTargetModes - kLoadVectors)
    throw Failure(
        content_error(text("--target-error keeps at most %d coordinates: --linear-modes "
                           "must be at most %d",
                           kMostTargetModes, kMostTargetModes - kLoadVectors)));
  if (mpi_ranks() > 1)
    throw Failure(
        {ErrorKind::kUsage,
         "--target-error works in one process: start it without mpiexec, with --threads"});
}

// Half of the coordinates are left for derivatives: 30 coordinates from 20 modes leave 61 % of the
// motion of a sample tower out, from 15 modes 12 % (docs/error.md, "Time to 1 % error"). Fewer
// coordinates are asked for where the modes themselves are wanted.
int default_linear_modes(const BasisRequest& request) {
  const int r = request.modes.value_or(kDefaultModes);
  return request.linear || request.target_error || r < kDefaultModes
             ? kMostDefaultLinear
             : std::min(kMostDefaultLinear, r / 2);
}

}  // namespace

ModeCounts choose_mode_counts(const BasisRequest& request, int free_dofs) {
  ModeCounts counts;
  counts.linear = request.linear_modes.value_or(std::min(default_linear_modes(request), free_dofs));
  const auto refuse = [](const std::string& text) { throw Failure(content_error(text)); };
  if (counts.linear < 1)
    refuse("--linear-modes " + std::to_string(counts.linear) + ": at least one is needed");
  if (counts.linear > free_dofs)
    refuse("--linear-modes " + std::to_string(counts.linear) + ": the mesh has " +
           std::to_string(free_dofs) + " dofs to move");
  const std::size_t k = counts.linear;
  const int most =
      static_cast<int>(std::min<std::size_t>(k + (request.linear ? 0 : pair_count(k)), free_dofs));
  counts.modes = request.modes.value_or(request.linear ? most : std::min(kDefaultModes, most));
  if (counts.modes < 1 || counts.modes > most)
    refuse("--modes " + std::to_string(counts.modes) + ": " + std::to_string(counts.linear) +
           " linear modes" + (request.linear ? "" : " and their derivatives") + " give at most " +
           std::to_string(most));
  const int kept = request.keep_modes.value_or(0);
  if (kept < 0 || kept > counts.linear || (kept > 0 && kept >= counts.modes))
    refuse("--keep-modes " + std::to_string(kept) + ": from 0 to the " +
           std::to_string(counts.linear) + " linear modes, and fewer than the " +
           std::to_string(counts.modes) + " coordinates");
  return counts;
}

void check_request(const PrecomputeRequest& request) {
  if (request.fit && mpi_ranks() > 1)
    throw Failure({ErrorKind::kUsage, "--fit works in one process: start it without mpiexec"});
  require_measurable(request.output, request.solid.load);
  require_reachable(request.basis, request.solid.load);
  choose_mode_counts(request.basis, std::numeric_limits<int>::max());
}

}  // namespace tremolo
