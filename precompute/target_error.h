// `--target-error`: chooses the number of coordinates for a given error.
//
// The nonlinear static problem f(u) = F under the default load is solved once on the whole mesh.
// Each prefix of the columns, in the order of their singular values, is a candidate basis; its own
// equilibrium U^T f(Uq) = U^T F is solved as well, and the result is the smallest r from which on
// |u - Uq| / |u| stays below the target. The energy of a larger basis restricted to the span of a
// prefix is that of the prefix, so coefficients are computed once for many r.
#pragma once

#include <optional>

#include <nlohmann/json.hpp>

#include "precompute/pipeline.h"
#include "precompute/reduction/basis.h"
#include "precompute/reference/full/step_equation.h"

namespace tremolo {

// Data that does not depend on the basis, on the free dofs in the order of the dof map. Empty until
// the first search.
struct TargetSearch {
  double asked = 0;
  std::string load_text;  // selector and force
  Vector load;            // F, N, without its rigid component
  Vector exact;           // u, m
  Vector response;        // K^-1 F, m
  Vector second;          // -K^-1 H[response, response], m; empty until needed
  double largest = 0;     // largest displacement of the loaded vertices, m
};

// Chooses r among bases of `principal`. Two columns for the load's own response (K^-1 F and the
// second-order term of the static solution) are added if the basis leaves out more than the target
// of the load's linear compliance without them, or if no r suffices without them. One process only.
// Throws Failure (kSolver) if the whole mesh has no equilibrium.
struct TargetBody {
  const Solid& solid;
  const Matrices& matrices;
  MassKind mass;
  unsigned threads;
};
TargetFindings find_coordinates(const LoadedProblem& loaded, const TargetBody& body,
                                PrincipalColumns& principal, TargetSearch& search);

// Calls run_precompute() with the number of linear modes and coordinates needed for
// basis.target_error; k grows up to twice if no r suffices. request: checked. Throws Failure:
// kContent for too many linear modes, kCriterion if the target is not reached.
PrecomputeResult precompute_to_target(const PrecomputeRequest& request, const LoadedProblem& loaded,
                                      StageLog& log);

std::string describe(const TargetFindings& findings);  // one line
std::string table_text(const TargetFindings& findings);

// Returns null if there are no findings.
nlohmann::ordered_json target_json(const std::optional<TargetFindings>& findings);

}  // namespace tremolo
