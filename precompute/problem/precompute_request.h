// The commands of tremolo-precompute that begin with a solid, as values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/basis/basis_writer.h"
#include "precompute/problem/problem_request.h"
#include "precompute/solver/solver_choice.h"

namespace tremolo {

inline constexpr int kMostTargetModes = 60;  // most coordinates with --target-error
inline constexpr int kLoadVectors = 2;       // of them, columns for the load's own response

struct BasisRequest {
  // k; default half of the coordinates, at most 20; 20 for fewer than 30 coordinates, for linear
  // models and with target_error; never more than the free dofs
  std::optional<int> linear_modes;
  std::optional<int> modes;  // r; default 30 or the most that k allows; k for a linear model
  std::optional<double>
      target_error;     // choose the smallest r that reaches it (target_error.h), dimensionless
  bool linear = false;  // the basis is the linear modes; no derivatives, no C, no Q
  // The lowest linear modes taken as they are (keep_lowest_modes()); none: decided by what they
  // would lose.
  std::optional<int> keep_modes;
  int derivatives = 3;  // up to which order: 3 adds those of third order (third_derivatives.h)
};

// Returns k and r. Defaults are reduced to what `free_dofs` (rigid motions subtracted) allows;
// throws Failure (kContent) if an explicit request exceeds it.
struct ModeCounts {
  int linear = 0;
  int modes = 0;
};
ModeCounts choose_mode_counts(const BasisRequest& request, int free_dofs);

// Places whose local response the file stores (local_response.h).
struct LocalResponseRequest {
  bool at_load = false;
  std::vector<Selector> at;  // each vertex is a place of its own
};

struct SolveRequest {
  std::optional<LinearSolver> solver;  // none: chosen automatically (solver_choice.h)
  std::optional<double> memory;        // bytes a rank may use; none: the free memory
  bool certify = true;                 // count the modes by inertia
  bool limits = false;  // measure the machine and print a lower bound for each stage's time
};

// Checkpoints of finished stages in a folder (precompute/checkpoint/checkpoint.h).
struct CheckpointRequest {
  std::string folder;
  bool keep = false;    // save each stage when it finishes
  bool resume = false;  // start from the stages saved in the folder
};

struct OutputRequest {
  std::string basis;      // the basis file
  std::string modes_vtu;  // the modes on the tetrahedra, for ParaView; empty: not written
  std::string preview;    // .ply of the fixed and loaded vertices; empty: not written
  BasisEncoding encoding = BasisEncoding::kFull;
  bool keep_elements = false;  // the tetrahedra and their masses stay in the file, for bones
  bool error_budget = false;   // measure what mesh, basis and step leave out (error_budget.h)
  bool sensitivities = false;  // derivatives of the frequencies with respect to the materials
  bool json = false;           // print a report on stdout
  std::string command_line;    // for the file's provenance
};

// Materials are fitted to measurements before anything else
// (precompute/sensitivity/material_fit.h).
struct FitRequest {
  std::string measured;            // the CSV file
  std::string unknowns = "young";  // read_unknowns
  std::string mass;                // KG or KG:SD; empty: not known
};

// Computes a basis; without output.basis fits materials or finds sensitivities only.
struct PrecomputeRequest {
  ProblemRequest solid;
  BasisRequest basis;
  LocalResponseRequest response;
  SolveRequest solve;
  CheckpointRequest checkpoint;
  std::optional<FitRequest> fit;
  OutputRequest output;
};

// Rejects numbers and combinations that are wrong for every mesh. Throws Failure (kUsage,
// kContent).
void check_request(const PrecomputeRequest& request);

// Turns VegaFEM's basis into a basis file; solid.imported is true.
struct ImportRequest {
  ProblemRequest solid;
  std::string basis_path;   // .U, at the vertices of the mesh
  std::string cubic_path;   // .cub
  bool mass_given = false;  // explicit request: orthonormalise the basis in elements.mass
  OutputRequest output;
};

// Prints selected vertices and writes their preview if it has a path. unwritten: a basis file that
// was named although nothing is computed.
struct SelectRequest {
  ProblemRequest solid;
  Selector selector;
  std::string preview;
  std::string unwritten;
};

// Writes the fixed and loaded vertices as a coloured surface.
struct PreviewRequest {
  ProblemRequest solid;
  std::string preview;
};

}  // namespace tremolo
