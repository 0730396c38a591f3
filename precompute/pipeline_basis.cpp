// Stages "target", "basis" and "coefficients".
#include <utility>

#include "common/packed_index.h"
#include "common/text.h"
#include "precompute/body_measures.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/pipeline_stages.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/inertia.h"
#include "precompute/reduction/polynomial_check.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

// Returns the first mode's coordinate at which some vertex moves by `reach`, m.
double amplitude_of_first_mode(const BasisRows& psi, double reach) {
  double largest = 0;
  for (Eigen::Index row = 0; row < psi.rows(); row += 3)
    largest = std::max(largest, psi.col(0).segment<3>(row).norm());
  return reach / over_ranks(largest, MPI_MAX);
}

// Reports the expected cost, as the work may take minutes.
void report_cost(const Columns& columns, unsigned threads, const Progress& progress) {
  const ManyColumnsCost cost = cost_of_many_columns(columns.rows(), columns.cols(), threads);
  progress(text("%d columns will take about %.2g s and %.2g GB", static_cast<int>(columns.cols()),
                cost.seconds, 1e-9 * cost.bytes));
}

// Returns modes and derivatives as directions in the order of their singular values; reuses the
// columns.
PrincipalColumns order_directions(const Run& run, const System& system, const Modes& modes,
                                  const BasisRows& psi, Columns& columns) {
  // The largest motion Tremolo is meant for is a tenth of the body's size.
  constexpr double kReach = 0.1;
  const double amplitude = amplitude_of_first_mode(psi, kReach * body_size(run.result.problem));
  const unsigned threads = run.request.threads;
  const Progress progress = [&run](const std::string& what) { run.log.note("basis: " + what); };
  if (columns.cols() >= kLarge) report_cost(columns, threads, progress);
  return principal_columns(system.matrices, std::move(columns), modes.squared_frequencies,
                           amplitude, threads, progress);
}

// Counts two Gram matrices, half of whose entries are computed, and one transformation of the
// columns.
StageWork work_on_columns(const Run& run, Eigen::Index columns) {
  const auto rows = static_cast<double>(run.result.local.dofs());
  return {.flops = 4.0 * rows * static_cast<double>(columns) * static_cast<double>(columns)};
}

FinishedBasis cut_basis(const Run& run, const System& system, PrincipalColumns directions,
                        double derivative_residual) {
  const ModelRequest& request = run.request;
  const PrecomputeResult& result = run.result;
  const bool extend = !request.modes && !request.target_error;
  FinishedBasis finished;
  finished.derivative_residual = derivative_residual;
  finished.basis = make_basis(system.matrices, std::move(directions),
                              {run.counts.modes, request.threads, &system.marker, extend});
  finished.rows = expand_to_vertices(result.map, result.local, finished.basis.vectors);
  fix_signs(result.local, finished.basis.vectors, finished.rows);
  finished.basis.vectors.resize(0, 0);
  return finished;
}

std::string outcome_of_basis(const FinishedBasis& finished) {
  const Basis& basis = finished.basis;
  const std::size_t r = basis.lambda.size();
  const std::vector<double>& sigma = basis.singular_values;
  return text("%zu coordinates, |U^T M U - I| = %.1e, first singular value cut %.1e of the largest",
              r, basis.orthonormality_error, r < sigma.size() ? sigma[r] / sigma[0] : 0.0);
}

// Ranks share the elements; all of them get the sum.
Eigen::MatrixXd sum_strain_gram(const Run& run, const System& system) {
  Eigen::MatrixXd gram =
      strain_gram(system.solid, run.result.rows, 0, run.result.local.counted, run.request.threads);
  sum_over_ranks(gram);
  return gram;
}

FinishedCoefficients compute_coefficients(const Run& run, const System& system) {
  const PrecomputeResult& result = run.result;
  const Eigen::MatrixXd gram = sum_strain_gram(run, system);
  const auto r = static_cast<int>(result.rows.cols());
  Coefficients made = coefficients_from_gram(gram, r);
  FinishedCoefficients coefficients;
  coefficients.strain_gram = packed_strain_gram(gram, r);
  coefficients.polynomial_error =
      polynomial_error(system.solid, result.local.counted, result.rows, result.data.lambda,
                       made.cubic, made.quartic, 0.5 * body_size(result.problem));
  coefficients.cubic = std::move(made.cubic);
  coefficients.quartic = std::move(made.quartic);
  return coefficients;
}

InertiaIntegrals integrate_inertia(const Run& run, const System& system) {
  const PrecomputeResult& result = run.result;
  const MassKind kind = run.request.mass;
  InertiaIntegrals inertia =
      basis_inertia(system.solid, result.local.counted, result.local, result.rows, kind);
  if (!system.part) {
    add_rest_moments(system.solid, kind, inertia);
    return inertia;
  }
  const Problem& problem = result.problem;
  Solid whole = make_solid(problem.mesh, problem.materials);
  whole.point_mass = mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  add_rest_moments(whole, kind, inertia);
  return inertia;
}

}  // namespace

Stage<TargetChoice> target_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source, TargetSearch& target) {
  const Eigen::Index columns = source.derivatives.columns.cols();
  const auto make = [&run, &system, &modes, &psi, &source, &target] {
    TargetChoice choice;
    choice.directions = order_directions(run, system, modes, psi, source.derivatives.columns);
    choice.findings = find_coordinates(run.request, run.result, system.solid, system.matrices,
                                       choice.directions, target);
    return choice;
  };
  return {.name = "target",
          .make = make,
          .outcome = [](const TargetChoice& choice) { return describe(choice.findings); },
          .work = [&run, columns](const TargetChoice&) { return work_on_columns(run, columns); }};
}

Stage<FinishedBasis> basis_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source) {
  const Eigen::Index columns = source.directions ? 0 : source.derivatives.columns.cols();
  const auto make = [&run, &system, &modes, &psi, &source] {
    PrincipalColumns directions =
        source.directions ? std::move(*source.directions)
                          : order_directions(run, system, modes, psi, source.derivatives.columns);
    return cut_basis(run, system, std::move(directions), source.derivatives.residual);
  };
  return {.name = "basis",
          .make = make,
          .outcome = outcome_of_basis,
          .work = [&run, columns](const FinishedBasis&) { return work_on_columns(run, columns); },
          .find = [&source] { return std::exchange(source.finished, std::nullopt); },
          .keep = [&run](const FinishedBasis& made) { keep_basis(run.checkpoint, made); }};
}

Stage<InertiaIntegrals> inertia_stage(const Run& run, const System& system) {
  const auto outcome = [](const InertiaIntegrals& made) {
    const Eigen::Vector3d centre = made.first_moment / made.mass;
    return text("%.4g kg, centre of mass %.4g %.4g %.4g m", made.mass, centre.x(), centre.y(),
                centre.z());
  };
  return {.name = "inertia",
          .make = [&run, &system] { return integrate_inertia(run, system); },
          .outcome = outcome};
}

Stage<FinishedCoefficients> coefficients_stage(const Run& run, const System& system) {
  const auto work = [&run](const FinishedCoefficients&) {
    const std::size_t r = run.counts.modes;
    const double columns = static_cast<double>(r + pair_count(r));
    const auto tetrahedra = static_cast<double>(run.result.problem.mesh.tetrahedra.size());
    const double samples =
        static_cast<double>(sample_points(run.result.problem.order, 4).size()) * tetrahedra;
    return StageWork{.flops = 6.0 * samples * columns * (columns + 1.0)};
  };
  const auto outcome = [](const FinishedCoefficients& made) {
    return text("%zu unique entries, |U^T f(Uq) - grad V| = %.1e relative",
                made.cubic.size() + made.quartic.size(), made.polynomial_error);
  };
  return {
      .name = "coefficients",
      .make = [&run, &system] { return compute_coefficients(run, system); },
      .outcome = outcome,
      .work = work,
      .find = [&run] { return find_coefficients(run.checkpoint, Eigen::Index{run.counts.modes}); },
      .keep =
          [&run](const FinishedCoefficients& made) { keep_coefficients(run.checkpoint, made); }};
}

}  // namespace tremolo
