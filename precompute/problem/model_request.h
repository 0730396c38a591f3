// What model of a solid is asked for, and how it is to be computed.
#pragma once

#include <optional>
#include <string>

#include "precompute/problem/problem_request.h"
#include "precompute/solver/solver_choice.h"

namespace tremolo {

// Finished stages in a folder (precompute/checkpoint/checkpoint.h).
struct CheckpointRequest {
  std::string folder;
  bool keep = false;    // stages as they are finished
  bool resume = false;  // from those that are there
};

struct ModelRequest : ProblemRequest {
  std::optional<int> linear_modes;     // k; default 20 or what the mesh has
  std::optional<int> modes;            // r; default 30 or what k allows, all k of a linear model
  std::optional<double> target_error;  // r so that this is kept (target_error.h), dimensionless
  bool linear = false;                 // the linear modes are the basis; no derivatives, no C, no Q
  bool certify = true;
  std::optional<LinearSolver> solver;  // none: what fits (solver_choice.h)
  std::optional<double> memory;        // bytes a rank may use; none: what is free
  bool limits = false;  // measure the machine, print each stage's shortest possible time
  CheckpointRequest checkpoint;
};

// k and r, defaults cut to what `free_dofs` (rigid motions taken off) allows; what was asked for
// explicitly and is not there is a Failure (kContent).
struct ModeCounts {
  int linear = 0;
  int modes = 0;
};
ModeCounts choose_mode_counts(const ModelRequest& request, int free_dofs);

}  // namespace tremolo
