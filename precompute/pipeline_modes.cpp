// Stages "modes", "derivatives" and "certificate", which share a factor of the stiffness.
#include "common/format_text.h"
#include "common/hertz.h"
#include "precompute/body_measures.h"
#include "precompute/modes/block_lanczos.h"
#include "precompute/pipeline_stages.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/soundness.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::vector<Eigen::Vector3d> node_positions(const PrecomputeResult& result) {
  std::vector<Eigen::Vector3d> positions;
  const LocalDofs& local = result.local;
  for (int node = local.first_node; node < local.first_node + local.nodes; ++node) {
    const auto vertex = static_cast<std::size_t>(result.map.vertex_of_node[node]);
    positions.push_back(result.problem.mesh.vertices[vertex]);
  }
  return positions;
}

WholeModes lowest_modes(const Run& run, double shift) {
  const auto solve = [&](int count) {
    return run.choice.solver == LinearSolver::kIterative
               ? compute_modes_iteratively(run.matrices, count, run.rigid, shift,
                                           node_positions(run.result))
               : compute_modes(run.matrices, count, run.rigid, shift, run.options.threads,
                               run.choice.solver);
  };
  return compute_whole_modes(solve, run.matrices, run.counts.linear, !run.options.linear_modes,
                             run.marker, run.rigid);
}

void refuse_mechanism(const Run& run, const Modes& modes) {
  const PrecomputeResult& result = run.result;
  require_no_mechanism(result.problem, run.solid, result.local, modes,
                       expand_to_vertices(result.map, result.local, modes.vectors));
}

WholeModes held_modes(const Run& run) {
  try {
    return lowest_modes(run, 0.0);
  } catch (const Failure& failure) {
    // A stiffness that cannot be factorised is a mechanism's, as a rule: with a shift its motion
    // can be found, and the place told.
    if (failure.error().kind != ErrorKind::kSolver || mpi_ranks() > 1) throw;
    refuse_mechanism(run, lowest_modes(run, small_shift(run.result.problem, run.solid)).modes);
    throw;
  }
}

WholeModes free_modes(const Run& run) {
  WholeModes whole = lowest_modes(run, small_shift(run.result.problem, run.solid));
  // A thin body is far softer than a compact one: its derivatives want a smaller shift. One with a
  // small soft part is far stiffer than that part: so near to zero, K loses its digits.
  const double lowest = whole.modes.squared_frequencies[0], shift = whole.modes.shift;
  const bool good = -shift <= 0.1 * lowest && -shift >= 1e-7 * lowest;
  if (good || !(lowest > 0) || whole.modes.iterative != nullptr) return whole;
  refuse_mechanism(run, whole.modes);  // its frequency, rounding, would be no measure
  whole = WholeModes();                // its factor goes before there is another
  return lowest_modes(run, -0.02 * lowest);
}

// Columns solved for on the factor, `width` in one pass over it forwards and one backwards.
StageWork solves_on(const SparseCholesky& factor, int columns, int width) {
  StageWork work;
  work.flops = 4.0 * static_cast<double>(factor.entries()) * columns;
  work.factor_bytes = 8.0 * static_cast<double>(factor.entries());
  const int blocks = (columns + width - 1) / width;
  work.passes = 2.0 * blocks;
  return work;
}

void report_modes(const Run& run, const WholeModes& whole, bool found) {
  const Modes& modes = whole.modes;
  PrecomputeFindings& findings = run.result.findings;
  findings.factorisation = modes.factorisation;
  findings.mode_solver = modes.solver;
  findings.mode_residuals.assign(modes.residuals.begin(), modes.residuals.end());
  run.result.data.linear_mode_count = static_cast<std::uint64_t>(run.counts.linear);
  run.result.data.rigid_mode_count = static_cast<std::uint64_t>(run.rigid_count);
  if (modes.cholesky != nullptr) {
    StageWork work = solves_on(*modes.cholesky, modes.solves, kLanczosBlock);
    work.added_flops = modes.cholesky->flops();
    set_limit(run.machine, work, run.log);
  }
  run.log.end(text("%d modes, %.4g to %.4g Hz, residual %.1e, %s (%s)%s", run.counts.linear,
                   hertz(modes.squared_frequencies[0]),
                   hertz(modes.squared_frequencies[run.counts.linear - 1]),
                   modes.residuals.maxCoeff(), modes.factorisation.c_str(), modes.solver.c_str(),
                   origin(found)));
  if (!whole.note.empty()) run.log.note(whole.note);
  if (run.rigid_count > 0)
    run.log.note(
        text("a free body: its %d rigid motions are left out of the basis", run.rigid_count));
}

}  // namespace

WholeModes make_modes(Run& run, BasisRows& psi) {
  const PrecomputeResult& result = run.result;
  WholeModes whole;
  const bool found = find_modes(run.checkpoint, result.local.dofs(), run.counts.linear, whole);
  if (!found) whole = result.problem.free_body ? free_modes(run) : held_modes(run);
  Modes& modes = whole.modes;
  if (const auto count = static_cast<int>(modes.vectors.cols()); count != run.counts.linear) {
    PrecomputeOptions extended = run.options;
    extended.linear_modes = count;
    run.counts = choose_mode_counts(extended, 3 * result.map.nodes() - run.rigid_count);
  }
  psi = expand_to_vertices(result.map, result.local, modes.vectors);
  if (!found) {
    require_no_mechanism(result.problem, run.solid, result.local, modes, psi);
    fix_signs(result.local, modes.vectors, psi);
    keep_modes(run.checkpoint, whole);
  }
  report_modes(run, whole, found);
  return whole;
}

ModalDerivatives make_derivatives(Run& run, Modes& modes, const BasisRows& psi) {
  if (run.options.linear) return {modes.vectors, modes.vectors.cols(), 0.0};
  run.log.begin("derivatives");
  ModalDerivatives derivatives;
  const bool found = find_derivatives(run.checkpoint, modes.vectors, derivatives);
  if (!found) {
    restore_solver(run.matrices, run.rigid, run.choice.solver, node_positions(run.result), modes);
    derivatives = modal_derivatives(run.solid, run.result.local, run.matrices, modes, psi,
                                    run.rigid, run.options.threads);
    keep_derivatives(run.checkpoint, derivatives);
  }
  const int count = static_cast<int>(derivatives.vectors().cols());
  if (!found && modes.cholesky != nullptr)
    set_limit(run.machine, solves_on(*modes.cholesky, count, 2 * static_cast<int>(kLanes)),
              run.log);
  run.log.end(text("%d solves %s, residual %.1e%s", count,
                   run.choice.solver == LinearSolver::kIterative ? "by conjugate gradients"
                                                                 : "on the factor of the modes",
                   derivatives.residual, origin(found)));
  return derivatives;
}

void certify_modes(Run& run, Modes& modes) {
  if (!run.options.certify) return;
  if (run.choice.solver == LinearSolver::kIterative) {
    run.log.note(
        "not certified: counting modes by inertia needs a factor; --solver cholmod or mumps");
    return;
  }
  run.log.begin("certificate");
  InertiaCertificate certificate;
  const bool found = find_certificate(run.checkpoint, certificate);
  double flops = 0;
  if (!found) {
    // MUMPS makes another one for it, SLEPc's is of no use.
    if (modes.solves > 0 && run.choice.solver == LinearSolver::kCholmod)
      restore_solver(run.matrices, run.rigid, run.choice.solver, {}, modes);
    if (modes.cholesky != nullptr) flops = modes.cholesky->flops();
    certificate = certify(run.matrices, modes, run.rigid_count, run.options.threads);
  }
  PrecomputeFindings& findings = run.result.findings;
  findings.certified = certificate.complete();
  findings.inertia_count = certificate.counted;
  if (!certificate.complete())
    throw Failure({ErrorKind::kSolver,
                   text("modes were missed: inertia counts %d below %.6g Hz, %d were found",
                        certificate.counted, hertz(certificate.bound), certificate.expected)});
  if (!found) keep_certificate(run.checkpoint, certificate);
  set_limit(run.machine, {.flops = flops}, run.log);
  run.log.end(text("inertia counts the same %d modes below %.4g Hz, %s%s", certificate.counted,
                   hertz(certificate.bound), certificate.solver.c_str(), origin(found)));
}

}  // namespace tremolo
