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
PrincipalColumns order_directions(const BasisBody& body, Columns& columns, const StageLog& log) {
  // The largest motion Tremolo is meant for is a tenth of the body's size.
  constexpr double kReach = 0.1;
  const double amplitude =
      amplitude_of_first_mode(body.psi, kReach * body_size(body.loaded.problem));
  const Progress progress = [&log](const std::string& what) { log.note("basis: " + what); };
  if (columns.cols() >= kLarge) report_cost(columns, body.threads, progress);
  return principal_columns(body.system.matrices, std::move(columns), body.modes.squared_frequencies,
                           amplitude, body.threads, progress);
}

// Returns the directions for a cut after `count`. Those of --target-error have been chosen as they
// are, and those of a linear model are the modes.
PrincipalColumns cut_directions(const BasisBody& body, int count, BasisSource& source,
                                const StageLog& log) {
  const Modes& modes = body.modes;
  const bool linear = source.derivatives.columns.cols() == modes.vectors.cols();
  PrincipalColumns directions = order_directions(body, source.derivatives.columns, log);
  if (linear) return directions;
  const Eigen::Index kept =
      keep_lowest_modes(body.system.matrices, modes.vectors, modes.squared_frequencies, count,
                        body.keep_modes, body.threads, directions);
  if (kept > 0)
    log.note(
        text("basis: the lowest %d linear modes are taken as they are; derivatives fill the rest",
             static_cast<int>(kept)));
  return directions;
}

// Counts two Gram matrices, half of whose entries are computed, and one transformation of the
// columns.
StageWork work_on_columns(const LocalDofs& local, Eigen::Index columns) {
  const auto rows = static_cast<double>(local.dofs());
  return {.flops = 4.0 * rows * static_cast<double>(columns) * static_cast<double>(columns)};
}

FinishedBasis cut_basis(const BasisBody& body, int count, bool extend, PrincipalColumns directions,
                        double derivative_residual) {
  const LoadedProblem& loaded = body.loaded;
  FinishedBasis finished;
  finished.derivative_residual = derivative_residual;
  finished.basis = make_basis(body.system.matrices, std::move(directions),
                              {count, body.threads, &body.system.marker, extend});
  finished.rows = expand_to_vertices(loaded.map, loaded.local, finished.basis.vectors);
  fix_signs(loaded.local, finished.basis.vectors, finished.rows);
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

FinishedCoefficients compute_coefficients(const LoadedProblem& loaded, const System& system,
                                          const BasisRows& rows, const Eigen::VectorXd& lambda,
                                          unsigned threads) {
  const std::size_t counted = loaded.local.counted;
  // Ranks share the elements; all of them get the sum.
  Eigen::MatrixXd gram = strain_gram(system.solid, rows, 0, counted, threads);
  sum_over_ranks(gram);
  const auto r = static_cast<int>(rows.cols());
  Coefficients made = coefficients_from_gram(gram, r);
  FinishedCoefficients coefficients;
  coefficients.strain_gram = packed_strain_gram(gram, r);
  coefficients.polynomial_error = polynomial_error(system.solid, counted, rows, lambda, made.cubic,
                                                   made.quartic, 0.5 * body_size(loaded.problem));
  coefficients.cubic = std::move(made.cubic);
  coefficients.quartic = std::move(made.quartic);
  return coefficients;
}

InertiaIntegrals integrate_inertia(const LoadedProblem& loaded, const System& system,
                                   const BasisRows& rows, MassKind mass) {
  const LocalDofs& local = loaded.local;
  InertiaIntegrals inertia = basis_inertia(system.solid, local.counted, local, rows, mass);
  if (!system.part) {
    add_rest_moments(system.solid, mass, inertia);
    return inertia;
  }
  const Problem& problem = loaded.problem;
  Solid whole = make_solid(problem.mesh, problem.materials);
  whole.point_mass = mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  add_rest_moments(whole, mass, inertia);
  return inertia;
}

}  // namespace

Stage<TargetChoice> target_stage(const BasisBody& body, MassKind mass, BasisSource& source,
                                 TargetSearch& target, const StageLog& log) {
  const LocalDofs& local = body.loaded.local;
  const Eigen::Index columns = source.derivatives.columns.cols();
  const auto make = [body, mass, &source, &target, &log] {
    TargetChoice choice;
    choice.directions = order_directions(body, source.derivatives.columns, log);
    choice.findings =
        find_coordinates(body.loaded, {body.system.solid, body.system.matrices, mass, body.threads},
                         choice.directions, target);
    return choice;
  };
  return {
      .name = "target",
      .make = make,
      .outcome = [](const TargetChoice& choice) { return describe(choice.findings); },
      .work = [&local, columns](const TargetChoice&) { return work_on_columns(local, columns); }};
}

Stage<FinishedBasis> basis_stage(const BasisBody& body, int count, bool extend, BasisSource& source,
                                 Checkpoint& checkpoint, const StageLog& log) {
  const LocalDofs& local = body.loaded.local;
  const Eigen::Index columns = source.directions ? 0 : source.derivatives.columns.cols();
  const auto make = [body, count, extend, &source, &log] {
    PrincipalColumns directions = source.directions ? std::move(*source.directions)
                                                    : cut_directions(body, count, source, log);
    return cut_basis(body, count, extend, std::move(directions), source.derivatives.residual);
  };
  return {
      .name = "basis",
      .make = make,
      .outcome = outcome_of_basis,
      .work = [&local, columns](const FinishedBasis&) { return work_on_columns(local, columns); },
      .find = [&source] { return std::exchange(source.finished, std::nullopt); },
      .keep = [&checkpoint](const FinishedBasis& made) { keep_basis(checkpoint, made); }};
}

Stage<InertiaIntegrals> inertia_stage(const LoadedProblem& loaded, const System& system,
                                      const BasisRows& rows, MassKind mass) {
  const auto outcome = [](const InertiaIntegrals& made) {
    const Eigen::Vector3d centre = made.first_moment / made.mass;
    return text("%.4g kg, centre of mass %.4g %.4g %.4g m", made.mass, centre.x(), centre.y(),
                centre.z());
  };
  return {.name = "inertia",
          .make = [&, mass] { return integrate_inertia(loaded, system, rows, mass); },
          .outcome = outcome};
}

Stage<FinishedCoefficients> coefficients_stage(const LoadedProblem& loaded, const System& system,
                                               const BasisRows& rows, const Eigen::VectorXd& lambda,
                                               unsigned threads, Checkpoint& checkpoint) {
  const auto work = [&](const FinishedCoefficients&) {
    const std::size_t r = lambda.size();
    const double columns = static_cast<double>(r + pair_count(r));
    const auto tetrahedra = static_cast<double>(loaded.problem.mesh.tetrahedra.size());
    const double samples =
        static_cast<double>(sample_points(loaded.problem.order, 4).size()) * tetrahedra;
    return StageWork{.flops = 6.0 * samples * columns * (columns + 1.0)};
  };
  const auto outcome = [](const FinishedCoefficients& made) {
    return text("%zu unique entries, |U^T f(Uq) - grad V| = %.1e relative",
                made.cubic.size() + made.quartic.size(), made.polynomial_error);
  };
  return {
      .name = "coefficients",
      .make = [&, threads] { return compute_coefficients(loaded, system, rows, lambda, threads); },
      .outcome = outcome,
      .work = work,
      .find = [&] { return find_coefficients(checkpoint, lambda.size()); },
      .keep = [&](const FinishedCoefficients& made) { keep_coefficients(checkpoint, made); }};
}

}  // namespace tremolo
