#include "precompute/problem/model_request.h"

#include <algorithm>

#include "common/packed_index.h"
#include "precompute/system/failure.h"

namespace tremolo {

ModeCounts choose_mode_counts(const ModelRequest& request, int free_dofs) {
  ModeCounts counts;
  counts.linear = request.linear_modes.value_or(std::min(20, free_dofs));
  const auto refuse = [](const std::string& text) { throw Failure(content_error(text)); };
  if (counts.linear < 1)
    refuse("--linear-modes " + std::to_string(counts.linear) + ": at least one is needed");
  if (counts.linear > free_dofs)
    refuse("--linear-modes " + std::to_string(counts.linear) + ": the mesh has " +
           std::to_string(free_dofs) + " dofs to move");
  const std::size_t k = counts.linear;
  const int most =
      static_cast<int>(std::min<std::size_t>(k + (request.linear ? 0 : pair_count(k)), free_dofs));
  counts.modes = request.modes.value_or(request.linear ? most : std::min(30, most));
  if (counts.modes < 1 || counts.modes > most)
    refuse("--modes " + std::to_string(counts.modes) + ": " + std::to_string(counts.linear) +
           " linear modes" + (request.linear ? "" : " and their derivatives") + " give at most " +
           std::to_string(most));
  return counts;
}

}  // namespace tremolo
