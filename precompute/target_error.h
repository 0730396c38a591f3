// `--target-error`: as many coordinates as a measured error asks for.
//
// The nonlinear static problem f(u) = F under the default load is solved once on the whole mesh. Of
// the columns in the order of their singular values each prefix is a basis; its own equilibrium
// U^T f(Uq) = U^T F is solved, too, and the smallest r is taken from which on |u - Uq| / |u| stays
// below the target. The energy of a larger basis' model restricted to the span of the prefix is the
// prefix's own: coefficients are computed once for many r.
#pragma once

#include <optional>

#include <nlohmann/json.hpp>

#include "precompute/pipeline.h"
#include "precompute/reduction/basis.h"
#include "precompute/reference/step_equation.h"

namespace tremolo {

inline constexpr int kMostTargetModes = 60;  // coordinates that are looked at
inline constexpr int kLoadVectors = 2;       // of them, the load's own response

// What is the same whatever the basis: over the free dofs in the order of the dof map. Empty until
// the first search.
struct TargetSearch {
  double asked = 0;
  Vector load;         // F, N, without its rigid share
  Vector exact;        // u, m
  Vector response;     // K^-1 F, m
  Vector second;       // K^-1 H[response, response], m; empty until it is asked for
  double largest = 0;  // of the loaded vertices, m
};

// Chooses r among bases of `principal`, to which the load's own response (two columns: K^-1 F and
// the second order of the static answer) is added when more than the target of the load's linear
// compliance is left out without it, or when no r is enough without it. One process. Throws Failure
// (kSolver) when the whole mesh has no equilibrium.
TargetFindings find_coordinates(const ModelRequest& request, const PrecomputeResult& result,
                                const Solid& solid, const Matrices& matrices,
                                PrincipalColumns& principal, TargetSearch& search);

// run_precompute() with as many linear modes and coordinates as request.target_error asks for: k
// grows twice when no r is enough. Throws Failure: kUsage on several ranks, kContent without a
// default load, for a target outside (0, 1) and too many linear modes, kCriterion when it is not
// reached.
PrecomputeResult precompute_to_target(const ModelRequest& request, StageLog& log);

std::string describe(const TargetFindings& findings);  // one line
std::string table_text(const TargetFindings& findings);

// null when there are none.
nlohmann::ordered_json target_json(const std::optional<TargetFindings>& findings);

}  // namespace tremolo
