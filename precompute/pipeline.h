// The stages in order: mesh -> matrices -> modes -> derivatives -> basis -> coefficients -> data.
#pragma once

#include <optional>
#include <string>

#include "common/stage_log.h"
#include "formats/basis/basis_data.h"
#include "precompute/budget/error_budget.h"
#include "precompute/problem/precompute_request.h"
#include "precompute/problem/problem.h"
#include "precompute/problem/wall_layers.h"
#include "precompute/ranks/row_gather.h"
#include "precompute/reduction/encoding_error.h"
#include "precompute/reduction/local_response.h"
#include "precompute/sensitivity/modal_forms.h"
#include "precompute/target_findings.h"

namespace tremolo {

// Result of the stage "mesh": the problem, its nodes divided among the ranks, and what is known
// before anything is solved.
struct LoadedProblem {
  Problem problem;
  DofMap map;
  LocalDofs local;
  std::vector<ResponsePlace> response_places;
  Locking locking;  // on rank 0 only
  // Number of a free body's rigid motions.
  int rigid_motions() const {
    return problem.free_body ? 6 * static_cast<int>(problem.report.parts) : 0;
  }
  int free_dofs() const { return 3 * map.nodes() - rigid_motions(); }
};

// The line on a free body's rigid motions, a warning if it has several parts; empty for count 0.
std::string note_on_rigid_motions(int count);

// Derivatives of the squared frequencies of the linear modes.
struct ModeSensitivities {
  Eigen::VectorXd squared_frequencies;  // k, (rad/s)^2
  std::vector<Cluster> clusters;        // of equal frequencies
  std::vector<ModeDerivatives> by;      // one a material
};

// Findings of a run, for the report and the file's provenance.
struct PrecomputeFindings {
  std::string factorisation;           // package of the factor
  std::string mode_solver;             // name of the eigensolver
  std::vector<double> mode_residuals;  // k
  double derivative_residual = 0;      // largest |K Phi + H| / |H|
  double orthonormality_error = 0;     // max |U^T M U - I|
  double diagonality_error = 0;        // max |U^T K U - Lambda| / max Lambda
  double response_residual = 0;        // largest |K X - G| / |G|
  double polynomial_error = 0;         // |U^T f(Uq) - grad V(q)| / |grad V(q)|
  bool resumed = false;                // some stage was read from a checkpoint
  bool certified = false;
  int inertia_count = 0;                           // modes below the bound, by inertia
  std::optional<EncodingError> encoding_error;     // of a compact file
  std::optional<TargetFindings> target;            // of --target-error
  std::optional<ErrorBudget> budget;               // of --error-budget
  std::optional<ModeSensitivities> sensitivities;  // of --sensitivities
  std::vector<std::string> notes;                  // for the user
};

struct PrecomputeResult {
  BasisData data;  // without rows; provenance is empty
  PrecomputeFindings findings;
  BasisRows rows;      // of U at the vertices of this rank's part of the mesh
  BasisRows response;  // of W, at the same vertices, 3 columns per point
};

inline SpreadBasis spread(const LoadedProblem& loaded, const BasisRows& rows) {
  return {loaded.problem.mesh, loaded.problem.embedding, loaded.map, loaded.local, rows};
}

// Runs the stage "mesh". Throws Failure. Collective.
LoadedProblem load_mesh(const PrecomputeRequest& request, StageLog& log);

// Runs all further stages; needs a PetscSession. Throws Failure. target: if given, chooses r
// (target_error.h); if it finds none the result has its findings only. Collective.
struct TargetSearch;
PrecomputeResult run_precompute(const PrecomputeRequest& request, const LoadedProblem& loaded,
                                StageLog& log, TargetSearch* target = nullptr);

// The linear modes alone, with their derivatives: no basis, no certificate, no checkpoint. Throws
// Failure. Collective.
ModeSensitivities solve_modes(const PrecomputeRequest& request, const LoadedProblem& loaded,
                              StageLog& log);

}  // namespace tremolo
