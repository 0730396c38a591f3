#include "precompute/budget/error_budget.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/text.h"
#include "precompute/fem/control_values.h"
#include "precompute/problem/element_order.h"
#include "precompute/reference/comparison.h"
#include "precompute/reference/full/full_order_solver.h"
#include "precompute/solver/solver_choice.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr SolveOptions kSolving{};
// For each entry of the sparse stiffness: that of mass, stiffness, tangent and its copies.
constexpr double kBytesACoupling = 60;

// A body at rest under the default load.
struct Rest {
  FullOrder body;
  Vector load, u;
};

Rest come_to_rest(const Problem& problem, const BudgetSubject& subject) {
  Rest rest{make_full_order(problem, subject.mass, subject.threads), {}, {}};
  rest.load = deforming_load(rest.body, point_load(rest.body, problem.load));
  if (rest.load.isZero(0.0))
    throw Failure(content_error("the default load (--load-at, --load-force) deforms nothing"));
  FullOrderSolver solver;
  solver.body = &rest.body;
  solver.options = kSolving;
  rest.u = static_solution(make_system(solver), rest.load).u;
  return rest;
}

// Displacements of the mesh's points, 3n.
BasisRows displacements(const Rest& rest) {
  BasisRows rows = expand(rest.body.unknowns, rest.u);
  to_displacements(rest.body.solid.mesh, rows);
  return rows;
}

double mass_norm(const FullOrder& body, const Vector& u) {
  return std::sqrt(u.dot(multiply(body, body.mass, u)));
}

// Throws if the factor of the refined mesh is too large for the user's memory limit, or without one
// for the default limit.
void require_refined_fits(const Problem& fine, const std::optional<double>& memory) {
  const DofMap map = make_dof_map(fine.mesh, fine.fixed, 1);
  const double entries = count_factor_entries(map);
  const double couplings = 9.0 * static_cast<double>(map.graph.neighbours.size() + map.nodes());
  const double bytes = 8.0 * entries + kBytesACoupling * couplings;
  if (memory ? bytes <= *memory : entries <= kMostRefinedEntries) return;
  throw Failure(system_error(
      text("the mesh refined once has %d unknowns, whose factor has %.2g entries: it "
           "takes about %.2g GB%s; a coarser mesh of the same body gives an estimate, too",
           3 * map.nodes(), entries, 1e-9 * bytes,
           memory ? "" : " and minutes, and is tried if --memory allows as much")));
}

// |u_h - u_{h/2}| / |u_{h/2}|.
double mesh_error(const Rest& rest, const BudgetSubject& subject) {
  const Problem fine = refined_problem(subject.problem);
  require_refined_fits(fine, subject.memory);
  const Rest finer = come_to_rest(fine, subject);
  const TetMesh& mesh = rest.body.solid.mesh;
  BasisRows there =
      displacements(finer).topRows(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  to_control_values(mesh, there);
  Vector better = restrict_to(rest.body.unknowns, there.col(0));
  remove_rigid_motion(rest.body, better);
  return mass_norm(rest.body, rest.u - better) / mass_norm(rest.body, better);
}

double basis_error(const Rest& rest, const BudgetSubject& subject) {
  const FullOrder& body = rest.body;
  Eigen::MatrixXd basis(body.size(), subject.rows.cols());
  for (Eigen::Index i = 0; i < body.size(); ++i)
    basis.row(i) = subject.rows.row(body.unknowns.dof[i]);
  const ReducedBody reduced = make_reduced_body(
      body, make_reduced_model(subject.data.lambda, subject.data.cubic, subject.data.quartic),
      std::move(basis));
  const Vector q =
      static_solution(make_system(reduced.model, kSolving), reduced.basis.transpose() * rest.load)
          .u;
  const Moment moment = compare(body, reduced, rest.u, multiply(body, body.mass, rest.u), q, {});
  return moment.difference / moment.norm;
}

// Measures a number, or records the reason why it cannot.
template <class Measure>
std::optional<double> attempt(const char* what, const Measure& measure, ErrorBudget& budget) {
  try {
    return measure();
  } catch (const Failure& failure) {
    budget.reasons.push_back(std::string(what) + ": " + failure.error().message);
    return std::nullopt;
  }
}

std::string number(const std::optional<double>& value) {
  return value ? text("%.2g", *value) : "not measured";
}

// Which of the three is the largest, as JSON calls it; empty if none was measured.
std::string largest_of(const ErrorBudget& budget) {
  std::pair<double, std::string> most{0.0, ""};
  for (const auto& [value, name] : {std::pair{budget.discretisation, "discretisation"},
                                    {budget.reduction, "reduction"},
                                    {budget.integration, "integration"}})
    if (value && *value > most.first) most = {*value, name};
  return most.second;
}

}  // namespace

ErrorBudget measure_budget(const BudgetSubject& subject) {
  ErrorBudget budget;
  budget.order = subject.problem.order;
  std::optional<Rest> rest;
  const auto at_rest = [&]() -> const Rest& {
    if (!rest) rest.emplace(come_to_rest(subject.problem, subject));
    return *rest;
  };
  budget.reduction = attempt(
      "reduction", [&] { return basis_error(at_rest(), subject); }, budget);
  if (budget.reduction)
    budget.discretisation = attempt(
        "discretisation", [&] { return mesh_error(at_rest(), subject); }, budget);
  // Halving the element size reduces an error of order 2 to a quarter.
  if (budget.discretisation) budget.limit = *budget.discretisation * 4.0 / 3.0;
  budget.integration = attempt(
      "integration", [&] { return step_error(subject.file); }, budget);
  return budget;
}

std::string describe(const ErrorBudget& budget) {
  const std::string most = largest_of(budget);
  std::string advice;
  if (most == "discretisation")
    advice = budget.order == 1 ? "; spend on the mesh: --order 2, or finer"
                               : "; spend on the mesh: finer";
  if (most == "reduction") advice = "; spend on the basis: more --modes";
  if (most == "integration") advice = "; spend on the step";
  return "mesh " + number(budget.discretisation) +
         (budget.limit ? " (off its limit about " + number(budget.limit) + ")" : "") + ", basis " +
         number(budget.reduction) + ", step " + number(budget.integration) + advice;
}

nlohmann::ordered_json budget_json(const std::optional<ErrorBudget>& budget) {
  if (!budget) return nullptr;
  const auto number_or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  const std::string most = largest_of(*budget);
  return {{"discretisation", number_or_null(budget->discretisation)},
          {"discretisation_limit", number_or_null(budget->limit)},
          {"reduction", number_or_null(budget->reduction)},
          {"integration", number_or_null(budget->integration)},
          {"spend_on", most.empty() ? Json(nullptr) : Json(most)},
          {"not_measured", budget->reasons}};
}

}  // namespace tremolo
