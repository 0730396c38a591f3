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

System assemble_system(const LoadedProblem& loaded, MassKind mass) {
  const Problem& problem = loaded.problem;
  const LocalDofs& local = loaded.local;
  std::unique_ptr<const TetMesh> part;
  if (mpi_ranks() > 1) part = std::make_unique<const TetMesh>(part_mesh(problem.mesh, local));
  Solid solid = make_solid(part ? *part : problem.mesh, local.tetrahedra, problem.materials);
  solid.point_mass = point_mass_of_part(problem, local);
  Matrices matrices = assemble(solid, loaded.map, local, mass);
  Columns rigid = motions_of_free_body(problem, local, matrices.mass.get());
  Marker marker = make_marker(problem.mesh, problem.report.part_of_vertex, local);
  return {std::move(part), std::move(solid), std::move(matrices), std::move(rigid),
          std::move(marker)};
}

std::vector<Eigen::Vector3d> node_positions(const LoadedProblem& loaded) {
  std::vector<Eigen::Vector3d> positions;
  const LocalDofs& local = loaded.local;
  for (int node = local.first_node; node < local.first_node + local.nodes; ++node) {
    const std::size_t vertex = loaded.map.vertex_of_node[node];
    positions.push_back(loaded.problem.mesh.vertices[vertex]);
  }
  return positions;
}

void require_elastic(const Solved& on, const Modes& modes) {
  const LoadedProblem& loaded = on.loaded;
  require_no_mechanism(loaded.problem, on.system.solid, loaded.local, modes,
                       expand_to_vertices(loaded.map, loaded.local, modes.vectors));
}

Modes held_modes(const Solved& on, int count) {
  try {
    return compute_modes_and_equals(on.pencil, on.solver, 0.0, count);
  } catch (const Failure& failure) {
    // A stiffness that cannot be factorised usually has a mechanism: with a shift its motion can be
    // computed, and the error can name its position.
    if (failure.error().kind != ErrorKind::kSolver || mpi_ranks() > 1) throw;
    const double shift = small_shift(on.loaded.problem, on.system.solid);
    require_elastic(on, compute_modes_and_equals(on.pencil, on.solver, shift, count));
    throw;
  }
}

Modes free_modes(const Solved& on, int count) {
  const double first = small_shift(on.loaded.problem, on.system.solid);
  Modes modes = compute_modes_and_equals(on.pencil, on.solver, first, count);
  // The shift must suit the lowest frequency: a thin body is far softer than a compact one, and its
  // derivatives need a smaller shift; a body with a small soft part is far stiffer than that part,
  // and a shift so near zero would cost K its digits.
  const double lowest = modes.squared_frequencies[0], shift = modes.shift;
  const bool good = -shift <= 0.1 * lowest && -shift >= 1e-7 * lowest;
  if (good || !(lowest > 0) || on.solver.solves_unshifted()) return modes;
  require_elastic(on, modes);  // for a mechanism the frequency is rounding and no measure
  modes = Modes();
  return compute_modes_and_equals(on.pencil, on.solver, -0.02 * lowest, count);
}

// Clusters are made canonical and signs fixed, so that vectors do not depend on the solver.
WholeModes elastic_modes(const Solved& on, int count, bool extend) {
  const LoadedProblem& loaded = on.loaded;
  Modes modes = loaded.problem.free_body ? free_modes(on, count) : held_modes(on, count);
  WholeModes whole = make_whole(on.pencil.mass(), on.system.marker, count,
                                available_modes(on.pencil), extend, std::move(modes));
  Columns& vectors = whole.modes.vectors;
  BasisRows psi = expand_to_vertices(loaded.map, loaded.local, vectors);
  require_no_mechanism(loaded.problem, on.system.solid, loaded.local, whole.modes, psi);
  fix_signs(loaded.local, vectors, psi);
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

Stage<System> matrices_stage(const LoadedProblem& loaded, MassKind mass) {
  return {
      .name = "matrices",
      .make = [&loaded, mass] { return assemble_system(loaded, mass); },
      .outcome =
          [&loaded](const System&) {
            return text("%d dofs, %.6g kg", 3 * loaded.map.nodes(), total_mass(loaded.problem));
          },
      .notes =
          [&loaded](const System& system) { return material_notes(loaded.problem, system.solid); }};
}

Pencil make_pencil(const LoadedProblem& loaded, const System& system, LinearSolver package,
                   unsigned threads) {
  return {system.matrices, system.rigid, package, threads, node_positions(loaded)};
}

std::string note_on_rigid_motions(int count) {
  if (count <= 0) return "";
  if (count == 6) return "a free body: its 6 rigid motions are left out of the basis";
  return text(
      "warning: a free body of %d parts that are not connected: its %d rigid motions are left out "
      "of the basis, so the parts cannot move against each other. Make a model of each part, join "
      "them, or hold them by --fix",
      count / 6, count);
}

Stage<WholeModes> modes_stage(const Solved& on, int count, bool extend, Checkpoint& checkpoint) {
  const auto outcome = [](const WholeModes& whole) {
    const Modes& modes = whole.modes;
    const Eigen::Index k = modes.squared_frequencies.size();
    return text("%d modes, %.4g to %.4g Hz, residual %.1e, %s (%s)", static_cast<int>(k),
                hertz(modes.squared_frequencies[0]), hertz(modes.squared_frequencies[k - 1]),
                modes.residuals.maxCoeff(), modes.factorisation.c_str(), modes.solver.c_str());
  };
  const auto notes = [on](const WholeModes& whole) {
    std::vector<std::string> lines;
    if (!whole.note.empty()) lines.push_back(whole.note);
    const std::string rigid = note_on_rigid_motions(on.loaded.rigid_motions());
    if (!rigid.empty()) lines.push_back(rigid);
    return lines;
  };
  const auto work = [on](const WholeModes& whole) {
    if (whole.modes.solves == 0) return StageWork();
    StageWork done = solves_on(on.solver, whole.modes.solves, kLanczosBlock);
    done.added_flops = on.solver.flops();
    return done;
  };
  return {.name = "modes",
          .make = [=] { return elastic_modes(on, count, extend); },
          .outcome = outcome,
          .notes = notes,
          .work = work,
          .find = [&checkpoint, on,
                   count] { return find_modes(checkpoint, on.loaded.local.dofs(), count); },
          .keep = [&checkpoint](const WholeModes& whole) { keep_modes(checkpoint, whole); }};
}

Stage<ModeSensitivities> sensitivities_stage(const Solved& on, const Modes& modes,
                                             const BasisRows& psi, MassKind mass) {
  const auto make = [&modes, &psi, on, mass] {
    const Eigen::VectorXd& squared = modes.squared_frequencies;
    ModeSensitivities found;
    found.squared_frequencies = squared;
    found.clusters = find_clusters(squared, nearness(squared[0], modes.cancellation));
    const auto counted = static_cast<std::size_t>(on.loaded.local.counted);
    for (const ModalForms& forms : modal_forms(on.system.solid, counted, psi, mass))
      found.by.push_back(mode_derivatives(forms, squared, found.clusters));
    return found;
  };
  return {.name = "sensitivities", .make = make, .outcome = [](const ModeSensitivities& found) {
            return text("%d modes, %d materials",
                        static_cast<int>(found.squared_frequencies.size()),
                        static_cast<int>(found.by.size()));
          }};
}

Stage<ModalDerivatives> derivatives_stage(const Solved& on, const Modes& modes,
                                          const BasisRows& psi, int order, Checkpoint& checkpoint) {
  const auto count = [](const ModalDerivatives& derivatives) {
    return static_cast<int>(derivatives.vectors().cols());
  };
  return {
      .name = "derivatives",
      .make =
          [&modes, &psi, on, order] {
            on.solver.prepare(modes.shift);
            const LoadedProblem& loaded = on.loaded;
            const Solid& solid = on.system.solid;
            ModalDerivatives derivatives =
                modal_derivatives(solid, loaded.local, on.pencil, on.solver, modes.vectors, psi);
            if (order > 2)
              add_third_derivatives({solid, loaded.map, loaded.local, on.pencil, on.solver}, psi,
                                    leading_modes(modes.squared_frequencies), derivatives);
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
      .find = [&checkpoint, &modes] { return find_derivatives(checkpoint, modes.vectors); },
      .keep = [&checkpoint](const ModalDerivatives& made) { keep_derivatives(checkpoint, made); }};
}

Stage<RestResponse> response_stage(const Solved& on, const Modes& modes) {
  return {.name = "response",
          .make =
              [&modes, on] {
                on.solver.prepare(modes.shift);
                return rest_response(on.loaded.response_places, on.loaded.local, on.pencil,
                                     on.solver);
              },
          .outcome =
              [on](const RestResponse& response) {
                return text("forces at %zu places, residual %.1e", on.loaded.response_places.size(),
                            response.residual);
              },
          .work =
              [on](const RestResponse& response) {
                const auto columns = static_cast<int>(response.columns.cols());
                return solves_on(on.solver, columns, 2 * static_cast<int>(kLanes));
              }};
}

Stage<InertiaCertificate> certificate_stage(const Solved& on, const Modes& modes,
                                            Checkpoint& checkpoint) {
  const auto make = [&modes, on] {
    InertiaCertificate certificate = certify(on.solver, modes, on.loaded.rigid_motions());
    if (!certificate.complete())
      throw Failure({ErrorKind::kSolver,
                     text("modes were missed: inertia counts %d below %.6g Hz, %d were found",
                          certificate.counted, hertz(certificate.bound), certificate.expected)});
    return certificate;
  };
  return {.name = "certificate",
          .make = make,
          .outcome =
              [](const InertiaCertificate& certificate) {
                return text("inertia counts the same %d modes below %.4g Hz, %s",
                            certificate.counted, hertz(certificate.bound),
                            certificate.solver.c_str());
              },
          .work = [on](const InertiaCertificate&) { return StageWork{.flops = on.solver.flops()}; },
          .find = [&checkpoint] { return find_certificate(checkpoint); },
          .keep = [&checkpoint](
                      const InertiaCertificate& made) { keep_certificate(checkpoint, made); }};
}

}  // namespace tremolo
