// Stages "target", "basis" and "coefficients".
#include "common/format_text.h"
#include "common/packed_index.h"
#include "precompute/body_measures.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/pipeline_stages.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/polynomial_check.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

// The first mode's coordinate when it moves some vertex by `reach` metres.
double amplitude_of_first_mode(const BasisRows& psi, double reach) {
  double largest = 0;
  for (Eigen::Index row = 0; row < psi.rows(); row += 3)
    largest = std::max(largest, psi.col(0).segment<3>(row).norm());
  return reach / over_ranks(largest, MPI_MAX);
}

// Ranks share the elements; every rank ends up with the sum.
Coefficients sum_coefficients(const Run& run) {
  const BasisRows& rows = run.result.rows;
  Eigen::MatrixXd gram =
      strain_gram(run.solid, rows, 0, run.result.local.counted, run.options.threads);
  sum_over_ranks(gram);
  return coefficients_from_gram(gram, static_cast<int>(rows.cols()));
}

FinishedCoefficients compute_coefficients(const Run& run) {
  const PrecomputeResult& result = run.result;
  Coefficients made = sum_coefficients(run);
  FinishedCoefficients coefficients;
  coefficients.polynomial_error =
      polynomial_error(run.solid, result.local.counted, result.rows, result.data.lambda, made.cubic,
                       made.quartic, 0.5 * body_size(result.problem));
  coefficients.cubic = std::move(made.cubic);
  coefficients.quartic = std::move(made.quartic);
  return coefficients;
}

// Before minutes of work.
void tell_cost(const Run& run, const Columns& columns, const Tell& tell) {
  const ManyColumnsCost cost =
      cost_of_many_columns(columns.rows(), columns.cols(), run.options.threads);
  tell(text("%d columns will take about %.2g s and %.2g GB", static_cast<int>(columns.cols()),
            cost.seconds, 1e-9 * cost.bytes));
}

// Takes the numbers over and the rows away.
void report_basis(Run& run, FinishedBasis finished, bool found) {
  const Basis& basis = finished.basis;
  PrecomputeFindings& findings = run.result.findings;
  BasisData& data = run.result.data;
  const std::string cut_note = note_on_cut(basis.cut, run.counts.modes, basis.lambda.size());
  run.counts.modes = static_cast<int>(basis.lambda.size());
  run.result.rows = std::move(finished.rows);
  findings.derivative_residual = finished.derivative_residual;
  findings.orthonormality_error = basis.orthonormality_error;
  findings.diagonality_error = basis.diagonality_error;
  data.lambda = basis.lambda;
  data.singular_values = basis.singular_values;
  const auto kept = static_cast<std::size_t>(run.counts.modes);
  run.log.end(text(
      "%d coordinates, |U^T M U - I| = %.1e, first singular value cut %.1e of the largest%s",
      run.counts.modes, basis.orthonormality_error,
      kept < basis.singular_values.size() ? basis.singular_values[kept] / basis.singular_values[0]
                                          : 0.0,
      origin(found)));
  if (!cut_note.empty()) run.log.note(cut_note);
  if (run.options.linear && run.counts.modes < run.counts.linear) {
    run.result.problem.notes.push_back(
        text("of the %d linear modes the basis keeps %d; --modes %d, the default, keeps all",
             run.counts.linear, run.counts.modes, run.counts.linear));
    run.log.note(run.result.problem.notes.back());
  }
}

}  // namespace

bool make_basis_rows(Run& run, const Modes& modes, const BasisRows& psi,
                     ModalDerivatives derivatives, TargetSearch* target, bool found,
                     FinishedBasis finished) {
  const PrecomputeOptions& options = run.options;
  PrecomputeResult& result = run.result;
  run.log.begin(target == nullptr ? "basis" : "target");
  // Two Gram matrices by half their entries and one change of the columns.
  const double columns = static_cast<double>(derivatives.columns.cols());
  set_limit(run.machine,
            {.flops = 4.0 * static_cast<double>(result.local.dofs()) * columns * columns}, run.log);
  if (!found) {
    // Motion that Tremolo is made for: a tenth of the body's size.
    constexpr double kReach = 0.1;
    const double amplitude = amplitude_of_first_mode(psi, kReach * body_size(result.problem));
    finished.derivative_residual = derivatives.residual;
    const Tell tell = [&run](const std::string& what) { run.log.note("basis: " + what); };
    if (derivatives.columns.cols() >= kLarge) tell_cost(run, derivatives.columns, tell);
    PrincipalColumns principal =
        principal_columns(run.matrices, std::move(derivatives.columns), modes.squared_frequencies,
                          amplitude, options.threads, tell);
    if (target != nullptr) {
      result.findings.target =
          find_coordinates(options, result, run.solid, run.matrices, principal, *target);
      run.log.end(describe(*result.findings.target));
      if (!result.findings.target->kept()) return false;
      run.counts.modes = result.findings.target->chosen.modes;
      run.log.begin("basis");
    }
    finished.basis = make_basis(run.matrices, std::move(principal), run.counts.modes,
                                options.threads, &run.marker, !options.modes && target == nullptr);
    finished.rows = expand_to_vertices(result.map, result.local, finished.basis.vectors);
    fix_signs(result.local, finished.basis.vectors, finished.rows);
    finished.basis.vectors.resize(0, 0);
    keep_basis(run.checkpoint, finished);
  }
  report_basis(run, std::move(finished), found);
  return true;
}

void make_coefficients(Run& run) {
  if (run.options.linear) return;
  run.log.begin("coefficients");
  const auto r = static_cast<std::size_t>(run.counts.modes);
  const double strain_columns = static_cast<double>(r + pair_count(r));
  const auto tetrahedra = static_cast<double>(run.result.problem.mesh.tetrahedra.size());
  set_limit(run.machine, {.flops = 6.0 * tetrahedra * strain_columns * (strain_columns + 1.0)},
            run.log);
  FinishedCoefficients coefficients;
  const bool found =
      find_coefficients(run.checkpoint, Eigen::Index{run.counts.modes}, coefficients);
  if (!found) {
    coefficients = compute_coefficients(run);
    keep_coefficients(run.checkpoint, coefficients);
  }
  BasisData& data = run.result.data;
  data.cubic = std::move(coefficients.cubic);
  data.quartic = std::move(coefficients.quartic);
  run.result.findings.polynomial_error = coefficients.polynomial_error;
  run.log.end(text("%zu unique entries, |U^T f(Uq) - grad V| = %.1e relative%s",
                   data.cubic.size() + data.quartic.size(), coefficients.polynomial_error,
                   origin(found)));
}

}  // namespace tremolo
