// `--error-budget`: the errors of mesh, basis and step, in one norm.
//
// discretisation and reduction are static, under the default load: |u_h - u_{h/2}| / |u_{h/2}| of
// this mesh against the one refined once (of the same order), and |u - Uq| / |u| of the reduced
// model against this mesh, |.| the M norm of this mesh. integration is in motion: max |q - q'| /
// max |q'| of `tremolo run` with its defaults under the load as square, 0.45 s, against a fifteenth
// of the step; as the basis is M-orthonormal, |q| is the M norm of Uq.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "formats/basis/basis_data.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// A factor of the refined mesh with more entries than this takes minutes and gigabytes: it is not
// tried unless the user says how much memory there is.
inline constexpr double kMostRefinedEntries = 3e8;

// The parts of the error; empty: not measured, for a reason in `reasons`. limit: Richardson's
// estimate of the mesh's distance from its limit, with order 2, which linear elements have and
// quadratic ones near re-entrant edges.
struct ErrorBudget {
  int order = 1;  // of the elements
  std::optional<double> discretisation, limit, reduction, integration;
  std::vector<std::string> reasons;
};

// The model whose error is measured.
struct BudgetSubject {
  const Problem& problem;
  MassKind mass = MassKind::kConsistent;
  const BasisData& data;
  const BasisRows& rows;  // U's control values, 3n x r
  std::string file;       // the basis file, already written
  unsigned threads = 1;
  std::optional<double> memory;  // bytes that the refined mesh may take; none: kMostRefinedEntries
};
ErrorBudget measure_budget(const BudgetSubject& subject);

// Relative error of the default step of `tremolo run` on a basis file. Throws Failure (kSystem) if
// that program is not in the same folder or fails.
double step_error(const std::string& file);

std::string describe(const ErrorBudget& budget);  // one line: the three, and where to spend
nlohmann::ordered_json budget_json(const std::optional<ErrorBudget>& budget);

}  // namespace tremolo
