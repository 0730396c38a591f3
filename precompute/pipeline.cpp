#include "precompute/pipeline.h"

#include "common/text.h"
#include "precompute/body_measures.h"
#include "precompute/pipeline_stages.h"
#include "precompute/problem/model_geometry.h"
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

LoadedProblem make_loaded(const PrecomputeRequest& request) {
  LoadedProblem loaded;
  loaded.problem = load_problem_together(request.solid);
  loaded.map = make_dof_map(loaded.problem.mesh, loaded.problem.fixed, mpi_ranks());
  loaded.local = local_dofs(loaded.problem.mesh, loaded.map, mpi_rank());
  loaded.response_places = response_places(loaded.problem, request.response);
  if (mpi_rank() == 0) loaded.locking = find_locking(loaded.problem);
  return loaded;
}

std::string outcome_of_mesh(const LoadedProblem& loaded) {
  const TetMesh& mesh = loaded.problem.mesh;
  return text("%zu vertices, %zu tetrahedra, %zu fixed vertices", mesh.vertices.size(),
              mesh.tetrahedra.size(), loaded.problem.fixed.size()) +
         (mesh.edges.empty()
              ? ""
              : text("; quadratic, %zu of the vertices are edge points", mesh.edges.size()));
}

std::vector<std::string> notes_of_mesh(const LoadedProblem& loaded) {
  std::vector<std::string> lines = loaded.problem.notes;
  for (const std::string& note : describe(loaded.locking)) lines.push_back(note);
  return lines;
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

// Decisions that are made before anything large is allocated.
struct Plan {
  BasisRequest basis;
  ModeCounts counts;
  LinearSolver solver = LinearSolver::kCholmod;
  bool certify = true;
  bool sensitivities = false;
  MassKind mass = MassKind::kConsistent;
  unsigned threads = 1;
};

SolverChoice choose(const PrecomputeRequest& request, const LoadedProblem& loaded,
                    const ModeCounts& counts) {
  SolverRequest asked;
  // The free memory may have changed since the stages were saved, so their solver is kept.
  asked.solver = request.solve.solver ? request.solve.solver : kept_solver(request.checkpoint);
  asked.memory = request.solve.memory;
  asked.order = loaded.problem.order;
  asked.linear_modes = counts.linear;
  asked.modes = counts.modes;
  asked.derivatives = !request.basis.linear;
  asked.rigid_modes = loaded.rigid_motions();
  asked.threads = request.solid.threads;
  return choose_solver(loaded.map, loaded.local, asked);
}

// If stiff and soft parts meet, rounding of large balanced forces in the stiff parts would dominate
// small forces elsewhere: rows are scaled by their own stiffness.
double residual_to_judge(const Solid& solid, const Modes& modes) {
  return solid.uniform() ? modes.residuals.maxCoeff() : modes.scaled_residual;
}

// The counts for the actual number of linear modes, which may be larger so that a cluster is not
// divided.
ModeCounts counts_of(const Plan& plan, const Modes& modes, int free_dofs) {
  const auto found = static_cast<int>(modes.vectors.cols());
  if (found == plan.counts.linear) return plan.counts;
  BasisRequest extended = plan.basis;
  extended.linear_modes = found;
  return choose_mode_counts(extended, free_dofs);
}

// Returns a source without derivatives if the basis is in the checkpoint or the model is linear.
BasisSource find_source(const Modes& modes, const BasisRows& psi, const ModeCounts& counts,
                        bool linear, Checkpoint& checkpoint) {
  BasisSource source;
  source.finished = find_basis(checkpoint, psi.rows(), Eigen::Index{counts.modes});
  if (!source.finished && linear) source.derivatives = {modes.vectors, modes.vectors.cols(), 0.0};
  return source;
}

// The stages with what is around each: its lower bound of time, its line in the log, its
// checkpoint.
struct StageRunner {
  const MachineLimits& machine;
  StageLog& log;
  Checkpoint& checkpoint;
  template <class Value>
  Value operator()(const Stage<Value>& stage) const {
    return run_stage(stage, machine, log);
  }
};

// Frontal matrices of a small factor are too small to share; more threads would only wait.
int blas_threads_for(const LoadedProblem& loaded, unsigned threads) {
  constexpr int kSmall = 50'000;  // dofs
  return 3 * loaded.map.nodes() < kSmall ? 1 : static_cast<int>(threads);
}

// Results of the stages that need the solver.
struct Solution {
  Modes modes;
  ModeCounts counts;
  BasisRows psi;  // the modes at the vertices of this rank's part
  BasisSource source;
  RestResponse response;
  InertiaCertificate certificate;
  bool certified = false;
  std::optional<ModeSensitivities> sensitivities;
};

Solution solve(const Plan& plan, const LoadedProblem& loaded, const System& system,
               const StageRunner& stage) {
  Checkpoint& checkpoint = stage.checkpoint;
  const Pencil pencil = make_pencil(loaded, system, plan.solver, plan.threads);
  const std::unique_ptr<ShiftedSolver> solver = make_shifted_solver(pencil);
  const Solved on{loaded, system, pencil, *solver};
  const bool extend = !plan.basis.linear_modes;
  Solution solution;
  solution.modes = stage(modes_stage(on, plan.counts.linear, extend, checkpoint)).modes;
  const Modes& modes = solution.modes;
  solution.counts = counts_of(plan, modes, loaded.free_dofs());
  solution.psi = expand_to_vertices(loaded.map, loaded.local, modes.vectors);
  if (plan.sensitivities)
    solution.sensitivities = stage(sensitivities_stage(on, modes, solution.psi, plan.mass));
  solution.source =
      find_source(modes, solution.psi, solution.counts, plan.basis.linear, checkpoint);
  if (!solution.source.finished && !plan.basis.linear)
    solution.source.derivatives =
        stage(derivatives_stage(on, modes, solution.psi, plan.basis.derivatives, checkpoint));
  if (!loaded.response_places.empty()) solution.response = stage(response_stage(on, modes));
  if (plan.certify && !solver->solves_unshifted()) {
    solution.certificate = stage(certificate_stage(on, modes, checkpoint));
    solution.certified = solution.certificate.complete();
  } else if (plan.certify) {
    stage.log.note(
        "not certified: counting modes by inertia needs a factor; --solver cholmod or mumps");
  }
  return solution;
}

PrecomputeFindings findings_of(const Solution& solution) {
  const Modes& modes = solution.modes;
  PrecomputeFindings findings;
  findings.factorisation = modes.factorisation;
  findings.mode_solver = modes.solver;
  findings.mode_residuals.assign(modes.residuals.begin(), modes.residuals.end());
  findings.certified = solution.certified;
  findings.inertia_count = solution.certificate.counted;
  findings.sensitivities = solution.sensitivities;
  return findings;
}

// Notes coordinates that were added or left out, and modes whose frequency is not the mesh's.
std::vector<std::string> notes_on(const Basis& basis, const Modes& modes, const ModeCounts& counts,
                                  bool linear, const StageLog& log) {
  const auto r = static_cast<int>(basis.lambda.size());
  const std::string cut = note_on_cut(basis.cut, counts.modes, r);
  if (!cut.empty()) log.note(cut);
  if (!linear) {
    const std::string high = note_on_modes(basis.lambda, modes.squared_frequencies);
    if (high.empty()) return {};
    log.note(high);
    return {high};
  }
  if (r >= counts.linear) return {};
  const std::string kept =
      text("of the %d linear modes the basis keeps %d; --modes %d, the default, keeps all",
           counts.linear, r, counts.linear);
  log.note(kept);
  return {kept};
}

void add_basis(FinishedBasis finished, PrecomputeResult& result) {
  result.rows = std::move(finished.rows);
  result.data.lambda = finished.basis.lambda;
  result.data.singular_values = finished.basis.singular_values;
  result.findings.derivative_residual = finished.derivative_residual;
  result.findings.orthonormality_error = finished.basis.orthonormality_error;
  result.findings.diagonality_error = finished.basis.diagonality_error;
}

void add_coefficients(FinishedCoefficients coefficients, PrecomputeResult& result) {
  result.data.cubic = std::move(coefficients.cubic);
  result.data.quartic = std::move(coefficients.quartic);
  result.data.strain_gram = std::move(coefficients.strain_gram);
  result.findings.polynomial_error = coefficients.polynomial_error;
}

void add_response(const RestResponse& response, const LoadedProblem& loaded,
                  PrecomputeResult& result) {
  if (loaded.response_places.empty()) return;
  result.findings.response_residual = response.residual;
  result.response = expand_to_vertices(loaded.map, loaded.local, response.columns);
  remove_basis_share(loaded.response_places, loaded.local, result.rows, result.data.lambda,
                     result.response);
}

// Adds to the file the geometry, the mass, and the counts.
void add_body(const LoadedProblem& loaded, const ModeCounts& counts, BasisData& data) {
  data.linear_mode_count = counts.linear;
  data.rigid_mode_count = loaded.rigid_motions();
  data.total_mass = total_mass(loaded.problem);
  add_geometry(loaded.problem, data);
}

PrecomputeResult reduce(const Plan& plan, const LoadedProblem& loaded, const System& system,
                        Solution solution, TargetSearch* target, const StageRunner& stage) {
  const bool linear = plan.basis.linear;
  const BasisBody body{loaded,       system,       solution.modes,
                       solution.psi, plan.threads, plan.basis.keep_modes};
  ModeCounts counts = solution.counts;
  PrecomputeResult result;
  result.findings = findings_of(solution);
  if (target != nullptr) {
    TargetChoice choice = stage(target_stage(body, plan.mass, solution.source, *target, stage.log));
    result.findings.target = choice.findings;
    if (!choice.findings.kept()) return result;
    counts.modes = choice.findings.chosen.modes;
    solution.source.directions = std::move(choice.directions);
  }
  const bool extend = !plan.basis.modes && !plan.basis.target_error;
  FinishedBasis finished =
      stage(basis_stage(body, counts.modes, extend, solution.source, stage.checkpoint, stage.log));
  result.findings.notes = notes_on(finished.basis, solution.modes, counts, linear, stage.log);
  add_basis(std::move(finished), result);
  add_response(solution.response, loaded, result);
  result.data.inertia = stage(inertia_stage(loaded, system, result.rows, plan.mass));
  if (!linear)
    add_coefficients(stage(coefficients_stage(loaded, system, result.rows, result.data.lambda,
                                              plan.threads, stage.checkpoint)),
                     result);
  result.findings.resumed = stage.checkpoint.found();
  require_accurate(result.findings, system.solid, residual_to_judge(system.solid, solution.modes),
                   solution.modes.cancellation);
  add_body(loaded, solution.counts, result.data);
  return result;
}

}  // namespace

LoadedProblem load_mesh(const PrecomputeRequest& request, StageLog& log) {
  return run_stage(Stage<LoadedProblem>{.name = "mesh",
                                        .make = [&request] { return make_loaded(request); },
                                        .outcome = outcome_of_mesh,
                                        .notes = notes_of_mesh},
                   {}, log);
}

ModeSensitivities solve_modes(const PrecomputeRequest& request, const LoadedProblem& loaded,
                              StageLog& log) {
  PrecomputeRequest modes_only = request;
  modes_only.basis.linear = true;
  modes_only.checkpoint = {};
  const ModeCounts counts = choose_mode_counts(modes_only.basis, loaded.free_dofs());
  const BlasThreads blas(blas_threads_for(loaded, request.solid.threads));
  const SolverChoice choice = choose(modes_only, loaded, counts);
  Checkpoint none({}, {}, log);
  const MachineLimits unknown;
  const StageRunner stage{unknown, log, none};
  const MassKind mass = request.solid.elements.mass;
  const System system = stage(matrices_stage(loaded, mass));
  const Pencil pencil = make_pencil(loaded, system, choice.solver, request.solid.threads);
  const std::unique_ptr<ShiftedSolver> solver = make_shifted_solver(pencil);
  const Solved on{loaded, system, pencil, *solver};
  const Modes modes = stage(modes_stage(on, counts.linear, true, none)).modes;
  const BasisRows psi = expand_to_vertices(loaded.map, loaded.local, modes.vectors);
  return stage(sensitivities_stage(on, modes, psi, mass));
}

PrecomputeResult run_precompute(const PrecomputeRequest& request, const LoadedProblem& loaded,
                                StageLog& log, TargetSearch* target) {
  const ModeCounts counts = choose_mode_counts(request.basis, loaded.free_dofs());
  const unsigned threads = request.solid.threads;
  const int blas_threads = blas_threads_for(loaded, threads);
  const BlasThreads blas(blas_threads);
  MachineLimits machine;
  if (request.solve.limits && mpi_ranks() == 1)
    machine = run_stage(machine_stage(threads), {}, log);

  const SolverChoice choice = choose(request, loaded, counts);
  log.note(choice.reason);
  if (target != nullptr) require_factor(choice, request.solve.solver);
  Checkpoint checkpoint(
      request.checkpoint,
      checkpoint_identity(request, loaded.problem, counts, choice.solver, blas_threads), log);
  const Plan plan{request.basis,
                  counts,
                  choice.solver,
                  request.solve.certify,
                  request.output.sensitivities,
                  request.solid.elements.mass,
                  threads};
  const StageRunner stage{machine, log, checkpoint};
  const System system = stage(matrices_stage(loaded, plan.mass));
  Solution solution = solve(plan, loaded, system, stage);
  return reduce(plan, loaded, system, std::move(solution), target, stage);
}

}  // namespace tremolo
