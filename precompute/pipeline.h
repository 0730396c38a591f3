// The stages in order: mesh -> matrices -> modes -> derivatives -> basis -> coefficients -> data.
#pragma once

#include <optional>

#include "common/stage_log.h"
#include "formats/basis/basis_data.h"
#include "precompute/budget/error_budget.h"
#include "precompute/problem/model_request.h"
#include "precompute/problem/problem.h"
#include "precompute/problem/wall_layers.h"
#include "precompute/ranks/row_gather.h"
#include "precompute/reduction/encoding_error.h"
#include "precompute/reduction/local_response.h"
#include "precompute/target_findings.h"

namespace tremolo {

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
  int inertia_count = 0;                        // modes below the bound, by inertia
  std::optional<EncodingError> encoding_error;  // of a compact file
  std::optional<TargetFindings> target;         // of --target-error
  Locking locking;                              // on rank 0 only
  std::optional<ErrorBudget> budget;            // of --error-budget
};

struct PrecomputeResult {
  BasisData data;  // without rows; provenance is empty
  Problem problem;
  PrecomputeFindings findings;
  DofMap map;
  LocalDofs local;
  BasisRows rows;  // of U at the vertices of this rank's part of the mesh
  std::vector<ResponsePlace> response_places;
  BasisRows response;  // of W, at the same vertices, 3 columns per point

  SpreadBasis basis() const { return {problem.mesh, problem.embedding, map, local, rows}; }
  SpreadBasis spread_response() const {
    return {problem.mesh, problem.embedding, map, local, response};
  }
};

// Runs all stages; needs a PetscSession. Throws Failure. target: if given, chooses r
// (target_error.h); if it finds none the result is incomplete.
struct TargetSearch;
PrecomputeResult run_precompute(const ModelRequest& request, StageLog& log,
                                TargetSearch* target = nullptr);

}  // namespace tremolo
