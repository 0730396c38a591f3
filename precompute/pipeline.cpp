#include "precompute/pipeline.h"

#include "common/format_text.h"
#include "precompute/body_measures.h"
#include "precompute/pipeline_stages.h"
#include "precompute/problem/model_geometry.h"
#include "precompute/problem/preview.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/soundness.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// --target-error solves on the whole mesh's factor, in one process by CHOLMOD.
void require_factor(const SolverChoice& choice, const std::optional<LinearSolver>& asked) {
  const bool too_many = choice.solver == LinearSolver::kMumps && !asked;
  if (choice.solver != LinearSolver::kIterative && !too_many) return;
  throw Failure(
      {asked ? ErrorKind::kUsage : ErrorKind::kSystem,
       "--target-error measures on a factor of the whole mesh's stiffness: " +
           (asked ? std::string("not with --solver iterative")
                  : "it does not fit (" + choice.reason + "). Give --modes, or a coarser mesh")});
}

std::vector<double> point_mass_of_part(const Problem& problem, const LocalDofs& local) {
  const std::vector<double> all =
      mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  std::vector<double> ours;
  if (!all.empty())
    for (const VertexId v : local.vertices) ours.push_back(all[static_cast<std::size_t>(v)]);
  return ours;
}

void load_mesh(const PrecomputeOptions& options, StageLog& log, PrecomputeResult& result) {
  log.begin("mesh");
  result.problem = load_problem_together(options);
  const Problem& problem = result.problem;
  result.map = make_dof_map(problem.mesh, problem.fixed, mpi_ranks());
  result.local = local_dofs(problem.mesh, result.map, mpi_rank());
  log.end(text("%zu vertices, %zu tetrahedra, %zu fixed vertices", problem.mesh.vertices.size(),
               problem.mesh.tetrahedra.size(), problem.fixed.size()));
  for (const std::string& note : problem.notes) log.note(note);
  if (mpi_rank() != 0) return;
  result.findings.locking = find_locking(problem);
  for (const std::string& note : describe(result.findings.locking)) log.note(note);
  write_preview(options, problem);
}

MachineLimits measure_limits(const PrecomputeOptions& options, StageLog& log) {
  if (!options.limits || mpi_ranks() > 1) return {};
  log.begin("machine");
  const MachineLimits machine = measure_machine(options.threads);
  log.end(text("%.4g GFLOP/s, %.4g GB/s read on %u threads", 1e-9 * machine.flops,
               1e-9 * machine.bytes, options.threads));
  return machine;
}

SolverChoice choose(const PrecomputeOptions& options, const PrecomputeResult& result,
                    const ModeCounts& counts, int rigid_count) {
  SolverRequest request;
  // Memory that is free now may be more or less than it was when the stages were made.
  request.solver = options.solver ? options.solver : kept_solver(options);
  request.memory = options.memory;
  request.linear_modes = counts.linear;
  request.modes = counts.modes;
  request.derivatives = !options.linear;
  request.rigid_modes = rigid_count;
  request.threads = options.threads;
  return choose_solver(result.map, result.local, request);
}

// Where stiff and soft parts meet, the rounding of large forces that balance in the stiff ones
// would drown the small ones: rows are compared in units of their own stiffness.
double residual_to_judge(const Solid& solid, const Modes& modes) {
  return solid.uniform() ? modes.residuals.maxCoeff() : modes.scaled_residual;
}

}  // namespace

PrecomputeResult run_precompute(const PrecomputeOptions& options, StageLog& log,
                                TargetSearch* target) {
  PrecomputeResult result;
  load_mesh(options, log, result);
  const Problem& problem = result.problem;
  const int dofs = 3 * result.map.nodes();
  const auto parts = static_cast<int>(problem.report.parts);
  const int rigid_count = problem.free_body ? 6 * parts : 0;
  const ModeCounts counts = choose_mode_counts(options, dofs - rigid_count);

  // The fronts of a small factor are too small to share: more threads only wait for each other.
  constexpr int kSmall = 100'000;  // dofs
  const int blas_threads = dofs < kSmall ? 1 : static_cast<int>(options.threads);
  const BlasThreads blas(blas_threads);
  const MachineLimits machine = measure_limits(options, log);

  const SolverChoice choice = choose(options, result, counts, rigid_count);
  log.note(choice.reason);
  if (target != nullptr) require_factor(choice, options.solver);
  Checkpoint checkpoint(
      options, checkpoint_identity(options, problem, counts, choice.solver, blas_threads), log);

  log.begin("matrices");
  const TetMesh part = mpi_ranks() > 1 ? part_mesh(problem.mesh, result.local) : TetMesh();
  Solid solid =
      make_solid(mpi_ranks() > 1 ? part : problem.mesh, result.local.tetrahedra, problem.materials);
  solid.point_mass = point_mass_of_part(problem, result.local);
  const Matrices matrices = assemble(solid, result.map, result.local, options.mass);
  result.data.total_mass = total_mass(problem);
  log.end(text("%d dofs, %.6g kg", dofs, result.data.total_mass));
  for (const std::string& note : material_notes(problem, solid)) log.note(note);

  log.begin("modes");
  const std::vector<int>& part_of_vertex = problem.report.part_of_vertex;
  Run run{.options = options,
          .log = log,
          .result = result,
          .machine = machine,
          .choice = choice,
          .solid = solid,
          .matrices = matrices,
          .checkpoint = checkpoint,
          .counts = counts,
          .rigid_count = rigid_count,
          .rigid = problem.free_body ? rigid_modes(problem.mesh, part_of_vertex, parts,
                                                   result.local, matrices.mass.get())
                                     : Columns(result.local.dofs(), 0),
          .marker = make_marker(problem.mesh, part_of_vertex, result.local)};
  BasisRows psi;
  WholeModes whole = make_modes(run, psi);
  Modes& modes = whole.modes;

  // A basis that is there makes the derivatives needless.
  FinishedBasis finished;
  const bool found = find_basis(checkpoint, psi.rows(), Eigen::Index{run.counts.modes}, finished);
  ModalDerivatives derivatives;
  if (!found) derivatives = make_derivatives(run, modes, psi);
  certify_modes(run, modes);
  release_solver(modes);
  if (!make_basis_rows(run, modes, psi, std::move(derivatives), target, found, std::move(finished)))
    return result;
  make_coefficients(run);

  result.findings.resumed = checkpoint.found();
  require_accurate(result.findings, solid, residual_to_judge(solid, modes), modes.cancellation);
  add_geometry(problem, result.data);
  return result;
}

}  // namespace tremolo
