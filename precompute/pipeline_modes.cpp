// Stages "matrices", "modes", "derivatives" and "certificate".
#include "common/text.h"
#include "common/units.h"
#include "precompute/body_measures.h"
#include "precompute/dense/lanes.h"
#include "precompute/modes/block_lanczos.h"
#include "precompute/pipeline_stages.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/reduction/local_response.h"
#include "precompute/reduction/third_derivatives.h"
#include "precompute/soundness.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::vector<double> point_mass_of_part(const Problem& problem, const LocalDofs& local) {
  const std::vector<double> all =
      mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  std::vector<double> local_mass;
  if (!all.empty())
    for (const VertexId v : local.vertices) local_mass.push_back(all[v]);
  return local_mass;
}

// Returns the rigid motions to be kept out of the modes.
Columns motions_of_free_body(const Problem& problem, const LocalDofs& local, Mat mass) {
  if (!problem.free_body) return Columns(local.dofs(), 0);
  return rigid_modes(problem.mesh, problem.report.part_of_vertex,
                     static_cast<int>(problem.report.parts), local, mass);
}

System assemble_system(const Run& run) {
  const Problem& problem = run.result.problem;
  const LocalDofs& local = run.result.local;
  std::unique_ptr<const TetMesh> part;
  if (mpi_ranks() > 1) part = std::make_unique<const TetMesh>(part_mesh(problem.mesh, local));
  Solid solid = make_solid(part ? *part : problem.mesh, local.tetrahedra, problem.materials);
  solid.point_mass = point_mass_of_part(problem, local);
  Matrices matrices = assemble(solid, run.result.map, local, run.request.mass);
  Columns rigid = motions_of_free_body(problem, local, matrices.mass.get());
  Marker marker = make_marker(problem.mesh, problem.report.part_of_vertex, local);
  return {std::move(part), std::move(solid), std::move(matrices), std::move(rigid),
          std::move(marker)};
}

std::vector<Eigen::Vector3d> node_positions(const PrecomputeResult& result) {
  std::vector<Eigen::Vector3d> positions;
  const LocalDofs& local = result.local;
  for (int node = local.first_node; node < local.first_node + local.nodes; ++node) {
    const std::size_t vertex = result.map.vertex_of_node[node];
    positions.push_back(result.problem.mesh.vertices[vertex]);
  }
  return positions;
}

void require_elastic(const Run& run, const Solved& on, const Modes& modes) {
  const PrecomputeResult& result = run.result;
  require_no_mechanism(result.problem, on.system.solid, result.local, modes,
                       expand_to_vertices(result.map, result.local, modes.vectors));
}

Modes lowest_modes(const Run& run, const Solved& on, double shift) {
  return compute_modes_and_equals(on.pencil, on.solver, shift, run.counts.linear);
}

Modes held_modes(const Run& run, const Solved& on) {
  try {
    return lowest_modes(run, on, 0.0);
  } catch (const Failure& failure) {
    // A stiffness that cannot be factorised usually has a mechanism: with a shift its motion can be
    // computed, and the error can name its position.
    if (failure.error().kind != ErrorKind::kSolver || mpi_ranks() > 1) throw;
    const double shift = small_shift(run.result.problem, on.system.solid);
    require_elastic(run, on, lowest_modes(run, on, shift));
    throw;
  }
}

Modes free_modes(const Run& run, const Solved& on) {
  Modes modes = lowest_modes(run, on, small_shift(run.result.problem, on.system.solid));
  // The shift must suit the lowest frequency: a thin body is far softer than a compact one, and its
  // derivatives need a smaller shift; a body with a small soft part is far stiffer than that part,
  // and a shift so near zero would cost K its digits.
  const double lowest = modes.squared_frequencies[0], shift = modes.shift;
  const bool good = -shift <= 0.1 * lowest && -shift >= 1e-7 * lowest;
  if (good || !(lowest > 0) || on.solver.solves_unshifted()) return modes;
  require_elastic(run, on, modes);  // for a mechanism the frequency is rounding and no measure
  modes = Modes();
  return lowest_modes(run, on, -0.02 * lowest);
}

// Clusters are made canonical and signs fixed, so that vectors do not depend on the solver.
WholeModes elastic_modes(const Run& run, const Solved& on) {
  const PrecomputeResult& result = run.result;
  Modes modes = result.problem.free_body ? free_modes(run, on) : held_modes(run, on);
  WholeModes whole =
      make_whole(on.pencil.mass(), on.system.marker, run.counts.linear, available_modes(on.pencil),
                 !run.request.linear_modes, std::move(modes));
  Columns& vectors = whole.modes.vectors;
  BasisRows psi = expand_to_vertices(result.map, result.local, vectors);
  require_no_mechanism(result.problem, on.system.solid, result.local, whole.modes, psi);
  fix_signs(result.local, vectors, psi);
  return whole;
}

// Returns the work of solving `columns` right-hand sides, `width` for each forward and backward
// pass.
StageWork solves_on(const ShiftedSolver& solver, int columns, int width) {
  StageWork work;
  work.flops = 4.0 * solver.entries() * columns;
  work.factor_bytes = 8.0 * solver.entries();
  const int blocks = (columns + width - 1) / width;
  work.passes = 2.0 * blocks;
  return work;
}

}  // namespace

Stage<System> matrices_stage(const Run& run) {
  return {.name = "matrices",
          .make = [&run] { return assemble_system(run); },
          .outcome =
              [&run](const System&) {
                return text("%d dofs, %.6g kg", 3 * run.result.map.nodes(),
                            total_mass(run.result.problem));
              },
          .notes =
              [&run](const System& system) {
                return material_notes(run.result.problem, system.solid);
              }};
}

Pencil make_pencil(const Run& run, const System& system) {
  return {system.matrices, system.rigid, run.choice.solver, run.request.threads,
          node_positions(run.result)};
}

Stage<WholeModes> modes_stage(const Run& run, const Solved& on) {
  const auto outcome = [](const WholeModes& whole) {
    const Modes& modes = whole.modes;
    const Eigen::Index k = modes.squared_frequencies.size();
    return text("%d modes, %.4g to %.4g Hz, residual %.1e, %s (%s)", static_cast<int>(k),
                hertz(modes.squared_frequencies[0]), hertz(modes.squared_frequencies[k - 1]),
                modes.residuals.maxCoeff(), modes.factorisation.c_str(), modes.solver.c_str());
  };
  const auto notes = [&run](const WholeModes& whole) {
    std::vector<std::string> lines;
    if (!whole.note.empty()) lines.push_back(whole.note);
    if (run.rigid_count > 0)
      lines.push_back(
          text("a free body: its %d rigid motions are left out of the basis", run.rigid_count));
    return lines;
  };
  const auto work = [on](const WholeModes& whole) {
    if (whole.modes.solves == 0) return StageWork();
    StageWork done = solves_on(on.solver, whole.modes.solves, kLanczosBlock);
    done.added_flops = on.solver.flops();
    return done;
  };
  return {
      .name = "modes",
      .make = [&run, on] { return elastic_modes(run, on); },
      .outcome = outcome,
      .notes = notes,
      .work = work,
      .find =
          [&run] { return find_modes(run.checkpoint, run.result.local.dofs(), run.counts.linear); },
      .keep = [&run](const WholeModes& whole) { keep_modes(run.checkpoint, whole); }};
}

Stage<ModalDerivatives> derivatives_stage(const Run& run, const Solved& on, const Modes& modes,
                                          const BasisRows& psi) {
  const auto count = [](const ModalDerivatives& derivatives) {
    return static_cast<int>(derivatives.vectors().cols());
  };
  return {.name = "derivatives",
          .make =
              [&run, &modes, &psi, on] {
                on.solver.prepare(modes.shift);
                const PrecomputeResult& result = run.result;
                const Solid& solid = on.system.solid;
                ModalDerivatives derivatives = modal_derivatives(solid, result.local, on.pencil,
                                                                 on.solver, modes.vectors, psi);
                if (run.request.derivatives > 2)
                  add_third_derivatives({solid, result.map, result.local, on.pencil, on.solver},
                                        psi, leading_modes(modes.squared_frequencies), derivatives);
                return derivatives;
              },
          .outcome =
              [count, on](const ModalDerivatives& derivatives) {
                return text("%d solves %s, residual %.1e", count(derivatives),
                            on.solver.solves_unshifted() ? "by conjugate gradients"
                                                         : "on the factor of the modes",
                            derivatives.residual);
              },
          .work =
              [count, on](const ModalDerivatives& derivatives) {
                return solves_on(on.solver, count(derivatives), 2 * static_cast<int>(kLanes));
              },
          .find = [&run, &modes] { return find_derivatives(run.checkpoint, modes.vectors); },
          .keep = [&run](const ModalDerivatives& made) { keep_derivatives(run.checkpoint, made); }};
}

Stage<RestResponse> response_stage(const Run& run, const Solved& on, const Modes& modes) {
  const PrecomputeResult& result = run.result;
  return {.name = "response",
          .make =
              [&result, &modes, on] {
                on.solver.prepare(modes.shift);
                return rest_response(result.response_places, result.local, on.pencil, on.solver);
              },
          .outcome =
              [&result](const RestResponse& response) {
                return text("forces at %zu places, residual %.1e", result.response_places.size(),
                            response.residual);
              },
          .work =
              [on](const RestResponse& response) {
                const auto columns = static_cast<int>(response.columns.cols());
                return solves_on(on.solver, columns, 2 * static_cast<int>(kLanes));
              }};
}

Stage<InertiaCertificate> certificate_stage(const Run& run, const Solved& on, const Modes& modes) {
  const auto make = [&run, &modes, on] {
    InertiaCertificate certificate = certify(on.solver, modes, run.rigid_count);
    if (!certificate.complete())
      throw Failure({ErrorKind::kSolver,
                     text("modes were missed: inertia counts %d below %.6g Hz, %d were found",
                          certificate.counted, hertz(certificate.bound), certificate.expected)});
    return certificate;
  };
  return {
      .name = "certificate",
      .make = make,
      .outcome =
          [](const InertiaCertificate& certificate) {
            return text("inertia counts the same %d modes below %.4g Hz, %s", certificate.counted,
                        hertz(certificate.bound), certificate.solver.c_str());
          },
      .work = [on](const InertiaCertificate&) { return StageWork{.flops = on.solver.flops()}; },
      .find = [&run] { return find_certificate(run.checkpoint); },
      .keep = [&run](const InertiaCertificate& made) { keep_certificate(run.checkpoint, made); }};
}

}  // namespace tremolo
