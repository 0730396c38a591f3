#include "precompute/pipeline.h"

#include <limits>

#include "common/text.h"
#include "precompute/body_measures.h"
#include "precompute/pipeline_stages.h"
#include "precompute/problem/model_geometry.h"
#include "precompute/problem/preview.h"
#include "precompute/ranks/halo.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/soundness.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// --target-error needs a factor of the whole mesh, in one process by CHOLMOD.
void require_factor(const SolverChoice& choice, const std::optional<LinearSolver>& asked) {
  const bool too_many = choice.solver == LinearSolver::kMumps && !asked;
  if (choice.solver != LinearSolver::kIterative && !too_many) return;
  throw Failure(
      {asked ? ErrorKind::kUsage : ErrorKind::kSystem,
       "--target-error measures on a factor of the whole mesh's stiffness: " +
           (asked ? std::string("not with --solver iterative")
                  : "it does not fit (" + choice.reason + "). Give --modes, or a coarser mesh")});
}

PrecomputeResult load_mesh(const ModelRequest& request) {
  PrecomputeResult result;
  result.problem = load_problem_together(request);
  const Problem& problem = result.problem;
  result.map = make_dof_map(problem.mesh, problem.fixed, mpi_ranks());
  result.local = local_dofs(problem.mesh, result.map, mpi_rank());
  result.response_places = response_places(problem, request.response_at);
  if (mpi_rank() != 0) return result;
  result.findings.locking = find_locking(problem);
  write_preview(request, problem);
  return result;
}

Stage<PrecomputeResult> mesh_stage(const ModelRequest& request) {
  const auto outcome = [](const PrecomputeResult& result) {
    const TetMesh& mesh = result.problem.mesh;
    return text("%zu vertices, %zu tetrahedra, %zu fixed vertices", mesh.vertices.size(),
                mesh.tetrahedra.size(), result.problem.fixed.size()) +
           (mesh.edges.empty()
                ? ""
                : text("; quadratic, %zu of the vertices are edge points", mesh.edges.size()));
  };
  const auto notes = [](const PrecomputeResult& result) {
    std::vector<std::string> lines = result.problem.notes;
    for (const std::string& note : describe(result.findings.locking)) lines.push_back(note);
    return lines;
  };
  return {.name = "mesh",
          .make = [&request] { return load_mesh(request); },
          .outcome = outcome,
          .notes = notes};
}

Stage<MachineLimits> machine_stage(unsigned threads) {
  return {.name = "machine",
          .make = [threads] { return measure_machine(threads); },
          .outcome =
              [threads](const MachineLimits& machine) {
                return text("%.4g GFLOP/s, %.4g GB/s read on %u threads", 1e-9 * machine.flops,
                            1e-9 * machine.bytes, threads);
              }};
}

SolverChoice choose(const ModelRequest& request, const PrecomputeResult& result,
                    const ModeCounts& counts, int rigid_count) {
  SolverRequest asked;
  // The free memory may have changed since the stages were saved, so their solver is kept.
  asked.solver = request.solver ? request.solver : kept_solver(request.checkpoint);
  asked.memory = request.memory;
  asked.order = result.problem.order;
  asked.linear_modes = counts.linear;
  asked.modes = counts.modes;
  asked.derivatives = !request.linear;
  asked.rigid_modes = rigid_count;
  asked.threads = request.threads;
  return choose_solver(result.map, result.local, asked);
}

// If stiff and soft parts meet, rounding of large balanced forces in the stiff parts would dominate
// small forces elsewhere: rows are scaled by their own stiffness.
double residual_to_judge(const Solid& solid, const Modes& modes) {
  return solid.uniform() ? modes.residuals.maxCoeff() : modes.scaled_residual;
}

// Stores the findings and adapts the counts to the actual number of linear modes.
void store_modes(const Modes& modes, Run& run, PrecomputeResult& result) {
  PrecomputeFindings& findings = result.findings;
  findings.factorisation = modes.factorisation;
  findings.mode_solver = modes.solver;
  findings.mode_residuals.assign(modes.residuals.begin(), modes.residuals.end());
  if (const auto count = static_cast<int>(modes.vectors.cols()); count != run.counts.linear) {
    ModelRequest extended = run.request;
    extended.linear_modes = count;
    run.counts = choose_mode_counts(extended, 3 * result.map.nodes() - run.rigid_count);
  }
  result.data.linear_mode_count = run.counts.linear;
  result.data.rigid_mode_count = run.rigid_count;
}

// Stores the basis and notes added or dropped coordinates.
void store_basis(FinishedBasis finished, Run& run, PrecomputeResult& result) {
  const Basis& basis = finished.basis;
  const std::string note = note_on_cut(basis.cut, run.counts.modes, basis.lambda.size());
  if (!note.empty()) run.log.note(note);
  run.counts.modes = static_cast<int>(basis.lambda.size());
  result.rows = std::move(finished.rows);
  result.findings.derivative_residual = finished.derivative_residual;
  result.findings.orthonormality_error = basis.orthonormality_error;
  result.findings.diagonality_error = basis.diagonality_error;
  result.data.lambda = basis.lambda;
  result.data.singular_values = basis.singular_values;
  if (!run.request.linear || run.counts.modes >= run.counts.linear) return;
  result.problem.notes.push_back(
      text("of the %d linear modes the basis keeps %d; --modes %d, the default, keeps all",
           run.counts.linear, run.counts.modes, run.counts.linear));
  run.log.note(result.problem.notes.back());
}

void store_response(RestResponse response, PrecomputeResult& result) {
  if (result.response_places.empty()) return;
  result.findings.response_residual = response.residual;
  result.response = expand_to_vertices(result.map, result.local, response.columns);
  remove_basis_share(result.response_places, result.local, result.rows, result.data.lambda,
                     result.response);
}

void store_coefficients(FinishedCoefficients coefficients, PrecomputeResult& result) {
  result.data.cubic = std::move(coefficients.cubic);
  result.data.quartic = std::move(coefficients.quartic);
  result.data.strain_gram = std::move(coefficients.strain_gram);
  result.findings.polynomial_error = coefficients.polynomial_error;
}

void store_certificate(const InertiaCertificate& certificate, PrecomputeFindings& findings) {
  findings.certified = certificate.complete();
  findings.inertia_count = certificate.counted;
}

// Returns a source without derivatives if the basis is in the checkpoint or the model is linear.
BasisSource find_source(const Run& run, const Modes& modes, Eigen::Index rows) {
  BasisSource source;
  source.finished = find_basis(run.checkpoint, rows, Eigen::Index{run.counts.modes});
  if (!source.finished && run.request.linear)
    source.derivatives = {modes.vectors, modes.vectors.cols(), 0.0};
  return source;
}

// Runs the stages from the matrices on, in order. Returns false if the target is not reached.
bool run_stages(Run& run, const MachineLimits& machine, StageLog& log, TargetSearch* target,
                PrecomputeResult& result) {
  const auto stage = [&](const auto& each) { return run_stage(each, machine, log); };
  const ModelRequest& request = run.request;
  const System system = stage(matrices_stage(run));
  const Pencil pencil = make_pencil(run, system);
  const std::unique_ptr<ShiftedSolver> solver = make_shifted_solver(pencil);
  const Solved on{system, pencil, *solver};

  const Modes modes = stage(modes_stage(run, on)).modes;
  store_modes(modes, run, result);
  const BasisRows psi = expand_to_vertices(result.map, result.local, modes.vectors);
  BasisSource source = find_source(run, modes, psi.rows());
  if (!source.finished && !request.linear)
    source.derivatives = stage(derivatives_stage(run, on, modes, psi));
  RestResponse response;
  if (!result.response_places.empty()) response = stage(response_stage(run, on, modes));
  if (request.certify && !solver->solves_unshifted())
    store_certificate(stage(certificate_stage(run, on, modes)), result.findings);
  else if (request.certify)
    log.note("not certified: counting modes by inertia needs a factor; --solver cholmod or mumps");
  solver->release();
  if (target != nullptr) {
    TargetChoice choice = stage(target_stage(run, system, modes, psi, source, *target));
    result.findings.target = choice.findings;
    if (!choice.findings.kept()) return false;
    run.counts.modes = choice.findings.chosen.modes;
    source.directions = std::move(choice.directions);
  }
  store_basis(stage(basis_stage(run, system, modes, psi, source)), run, result);
  store_response(std::move(response), result);
  result.data.inertia = stage(inertia_stage(run, system));
  if (!request.linear) store_coefficients(stage(coefficients_stage(run, system)), result);

  result.findings.resumed = run.checkpoint.found();
  require_accurate(result.findings, system.solid, residual_to_judge(system.solid, modes),
                   modes.cancellation);
  return true;
}

}  // namespace

PrecomputeResult run_precompute(const ModelRequest& request, StageLog& log, TargetSearch* target) {
  choose_mode_counts(
      request, std::numeric_limits<int>::max());  // reject counts that are wrong for every mesh
  PrecomputeResult result = run_stage(mesh_stage(request), {}, log);
  const Problem& problem = result.problem;
  const int dofs = 3 * result.map.nodes();
  const int rigid_count = problem.free_body ? 6 * static_cast<int>(problem.report.parts) : 0;
  const ModeCounts counts = choose_mode_counts(request, dofs - rigid_count);

  // Frontal matrices of a small factor are too small to share; more threads would only wait.
  constexpr int kSmall = 50'000;  // dofs
  const int blas_threads = dofs < kSmall ? 1 : static_cast<int>(request.threads);
  const BlasThreads blas(blas_threads);
  MachineLimits machine;
  if (request.limits && mpi_ranks() == 1)
    machine = run_stage(machine_stage(request.threads), {}, log);

  const SolverChoice choice = choose(request, result, counts, rigid_count);
  log.note(choice.reason);
  if (target != nullptr) require_factor(choice, request.solver);
  Checkpoint checkpoint(request.checkpoint,
                        checkpoint_identity(request, problem, counts, choice.solver, blas_threads),
                        log);
  result.data.total_mass = total_mass(problem);
  Run run{request, result, choice, checkpoint, log, counts, rigid_count};
  if (run_stages(run, machine, log, target, result)) add_geometry(problem, result.data);
  return result;
}

}  // namespace tremolo
