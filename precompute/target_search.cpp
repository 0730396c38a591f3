// Measurements for --target-error: candidates against the whole mesh.
#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "common/text.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reference/full/full_order_solver.h"
#include "precompute/reference/reduced_model.h"
#include "precompute/system/failure.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

constexpr int kBatch = 15;  // candidates per model; limits cost, as coefficients cost r^4
constexpr int kBeyond = 3;  // number of larger candidates that must also meet the target

void solve_exactly(const Problem& problem, FullOrderSolver& solver, TargetSearch& search) {
  const FullOrder& body = *solver.body;
  search.load = deforming_load(body, point_load(body, problem.load));
  const auto refuse = [] {
    throw Failure(content_error(
        "--target-error: the default load (--load-at, --load-force) deforms nothing"));
  };
  if (search.load.isZero(0.0)) refuse();
  search.exact = static_solution(make_system(solver), search.load).u;
  search.response = linear_response(solver, search.load);
  search.largest = largest_displacement(body, problem.load.vertices, search.exact);
  if (!(search.load.dot(search.response) > 0 && search.largest > 0)) refuse();
}

// The static solution under s F is s u1 + s^2/2 u2 + ... with K u1 = F, K u2 = -H[u1, u1].
Columns load_vectors(const LocalDofs& local, const Solid& solid, FullOrderSolver& solver,
                     TargetSearch& search) {
  if (search.second.size() == 0) {
    const Field field = expand(solver.body->unknowns, search.response);
    Vector force = Vector::Zero(search.response.size());
    add_second_derivative(solid, local.elements, field, field, local.row_of_vertex, force.data());
    remove_rigid_force(*solver.body, force);
    search.second = linear_response(solver, -force);
  }
  Columns vectors(search.response.size(), kLoadVectors);
  vectors.col(0) = search.response;
  vectors.col(1) = search.second;
  return vectors;
}

// Candidate bases: each prefix of `vectors` spans the same space as that prefix of the principal
// columns. vectors^T K vectors = 1, so the model of every prefix has unit stiffness.
struct Candidates {
  Columns vectors;
  std::vector<double> projection;  // |u - its projection| / |u| for r columns, at index r
  std::vector<double> unseen;      // at index r
};

Candidates make_candidates(const FullOrder& body, const PrincipalColumns& principal,
                           const TargetSearch& search) {
  const auto r = std::min<Eigen::Index>(kMostTargetModes, principal.size());
  Candidates candidates{principal.first(r), {1.0}, {1.0}};
  Columns& vectors = candidates.vectors;
  const Vector mass_exact = multiply(body, body.mass, search.exact);
  const double square = search.exact.dot(mass_exact);
  double left = square;
  for (Eigen::Index i = 0; i < r; ++i) {
    left -= std::pow(vectors.col(i).dot(mass_exact), 2);
    candidates.projection.push_back(std::sqrt(std::max(0.0, left / square)));
  }
  Columns image(vectors.rows(), r);
  for (Eigen::Index i = 0; i < r; ++i)
    image.col(i) = multiply(body, body.stiffness, vectors.col(i));
  const Eigen::LLT<Eigen::MatrixXd> factor(transposed_product(vectors, image));
  const Eigen::MatrixXd inverse = factor.matrixU().solve(Eigen::MatrixXd::Identity(r, r));
  add_product(1.0, Columns(vectors), inverse, 0.0, vectors);
  const double compliance = search.load.dot(search.response);
  double seen = 0;
  for (Eigen::Index i = 0; i < r; ++i) {
    seen += std::pow(vectors.col(i).dot(search.load), 2);
    candidates.unseen.push_back(std::max(0.0, 1 - seen / compliance));
  }
  return candidates;
}

ReducedModel model_of(const LoadedProblem& loaded, const Solid& solid, const Columns& vectors,
                      unsigned threads) {
  const BasisRows rows = expand_to_vertices(loaded.map, loaded.local, vectors);
  const auto r = static_cast<int>(vectors.cols());
  const Coefficients coefficients =
      coefficients_from_gram(strain_gram(solid, rows, 0, loaded.local.counted, threads), r);
  return make_reduced_model(Vector::Ones(r), coefficients.cubic, coefficients.quartic);
}

TargetRow measure(const FullOrder& body, const Problem& problem, const Candidates& candidates,
                  const ReducedModel& largest, int r, const TargetSearch& search) {
  TargetRow row;
  row.modes = r;
  row.projection = candidates.projection[r];
  row.unseen = candidates.unseen[r];
  const auto vectors = candidates.vectors.leftCols(r);
  const ReducedModel model = first_coordinates(largest, r);
  try {
    const Vector q = static_solution(make_system(model, {}), vectors.transpose() * search.load).u;
    const Vector off = search.exact - vectors * q;
    row.error = std::sqrt(off.dot(multiply(body, body.mass, off)) /
                          search.exact.dot(multiply(body, body.mass, search.exact)));
    row.tip = largest_displacement(body, problem.load.vertices, off) / search.largest;
  } catch (const Failure& failure) {
    if (failure.error().kind != ErrorKind::kSolver) throw;
  }
  return row;
}

// Returns the first candidate that, with kBeyond larger ones or all remaining ones, meets the
// target.
TargetRow choose(const std::vector<TargetRow>& rows, double target, bool all_measured) {
  std::size_t good = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    good = rows[i].error <= target ? good + 1 : 0;
    if (good > kBeyond) return rows[i + 1 - good];
  }
  return all_measured && good > 0 ? rows[rows.size() - good] : TargetRow();
}

// Data on which candidates are measured.
struct Setting {
  const FullOrder& body;
  const LoadedProblem& loaded;
  const Solid& solid;
  unsigned threads;
};

// Measures candidates until one is chosen.
void search_prefixes(const Setting& setting, const PrincipalColumns& principal,
                     const Candidates& candidates, const TargetSearch& search,
                     TargetFindings& findings) {
  const auto kept = static_cast<int>(principal.kept.cols());
  const auto most = static_cast<int>(candidates.vectors.cols());
  findings.rows.clear();
  // Statically fewer may suffice, but the requested linear modes are needed for vibration.
  const int least = std::min(most, kept + static_cast<int>(principal.linear_modes));
  for (int first = least; first <= most; first += kBatch) {
    const int last = std::min(most, first + kBatch - 1);
    const ReducedModel model =
        model_of(setting.loaded, setting.solid, candidates.vectors.leftCols(last), setting.threads);
    for (int r = first; r <= last; ++r) {
      // A cut within a cluster would keep an arbitrary part of it.
      if (cluster_at_cut(principal.singular_values.head(principal.rank), r - kept, {}).count > 0)
        continue;
      findings.rows.push_back(
          measure(setting.body, setting.loaded.problem, candidates, model, r, search));
      findings.chosen = choose(findings.rows, findings.asked, false);
      if (findings.kept()) return;
    }
  }
  // The last candidate may have been skipped because it divides a cluster.
  findings.chosen = choose(findings.rows, findings.asked, true);
}

}  // namespace

TargetFindings find_coordinates(const LoadedProblem& loaded, const TargetBody& on,
                                PrincipalColumns& principal, TargetSearch& search) {
  const FullOrder body = make_full_order(loaded.problem, on.mass, on.threads);
  FullOrderSolver solver;
  solver.body = &body;
  if (search.exact.size() == 0) solve_exactly(loaded.problem, solver, search);
  TargetFindings findings;
  findings.asked = search.asked;
  findings.linear_modes = static_cast<int>(principal.linear_modes);
  findings.load = search.load_text;
  const auto search_all = [&] {
    search_prefixes({body, loaded, on.solid, on.threads}, principal,
                    make_candidates(body, principal, search), search, findings);
  };
  const bool sees_load = make_candidates(body, principal, search).unseen.back() <= search.asked;
  if (sees_load) search_all();
  if (findings.kept() && findings.chosen.unseen <= search.asked) return findings;
  TargetFindings without = findings;
  const PrincipalColumns original = findings.kept() ? principal : PrincipalColumns();
  keep_always(on.matrices, load_vectors(loaded.local, on.solid, solver, search), on.threads,
              principal);
  findings.load_vectors = static_cast<int>(principal.kept.cols());
  search_all();
  if (findings.kept() || !without.kept()) return findings;
  principal = original;
  return without;
}

}  // namespace tremolo
