// Which model of a solid is requested, and how it is computed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "precompute/problem/problem_request.h"
#include "precompute/solver/solver_choice.h"

namespace tremolo {

// Checkpoints of finished stages in a folder (precompute/checkpoint/checkpoint.h).
struct CheckpointRequest {
  std::string folder;
  bool keep = false;    // save each stage when it finishes
  bool resume = false;  // start from the stages saved in the folder
};

struct ModelRequest : ProblemRequest {
  std::optional<int> linear_modes;  // k; default 20, or the number of free dofs if smaller
  std::optional<int> modes;         // r; default 30 or the most that k allows; k for a linear model
  std::optional<double>
      target_error;     // choose the smallest r that reaches it (target_error.h), dimensionless
  bool linear = false;  // the basis is the linear modes; no derivatives, no C, no Q
  int derivatives = 3;  // up to which order: 3 adds those of third order (third_derivatives.h)
  std::vector<std::string> response_at;  // selectors, or "load" (local_response.h)
  bool certify = true;
  std::optional<LinearSolver> solver;  // none: chosen automatically (solver_choice.h)
  std::optional<double> memory;        // bytes a rank may use; none: the free memory
  bool limits = false;  // measure the machine and print a lower bound for each stage's time
  CheckpointRequest checkpoint;
};

// Returns k and r. Defaults are reduced to what `free_dofs` (rigid motions subtracted) allows;
// throws Failure (kContent) if an explicit request exceeds it.
struct ModeCounts {
  int linear = 0;
  int modes = 0;
};
ModeCounts choose_mode_counts(const ModelRequest& request, int free_dofs);

}  // namespace tremolo
