#include "precompute/pipeline.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "common/format_text.h"
#include "common/packed_index.h"
#include "precompute/basis.h"
#include "precompute/blas_threads.h"
#include "precompute/block_lanczos.h"
#include "precompute/coefficients.h"
#include "precompute/derivatives.h"
#include "precompute/failure.h"
#include "precompute/limits.h"
#include "precompute/material_rules.h"
#include "precompute/modes.h"
#include "precompute/polynomial_check.h"
#include "precompute/rigid_motion.h"

namespace tremolo {
namespace {

double hertz(double squared_frequency) {
  return std::sqrt(squared_frequency) / (2.0 * std::numbers::pi);
}

// A free body's K is singular: a small negative shift, far below the first elastic mode of a
// compact body, makes it definite. Of several materials the softest and the densest count, and
// point masses as if the densest carried them.
double choose_shift(const Problem& problem, const Solid& solid) {
  if (!problem.free_body) return 0.0;
  const double size = bounding_box(problem.mesh.vertices).diagonal();
  double softest = std::numeric_limits<double>::max();
  for (const NamedMaterial& named : problem.materials.materials) {
    const Material& material = named.material;
    softest = std::min(softest, !material.orthotropic
                                    ? material.young
                                    : std::min(material.orthotropic->young.minCoeff(),
                                               2.0 * material.orthotropic->shear.minCoeff()));
  }
  double points = 0;
  for (const PointMass& mass : problem.point_masses) points += mass.kilograms;
  const double density = *std::max_element(solid.densities.begin(), solid.densities.end()) *
                         (1.0 + points / (total_mass(solid) - points));
  return -1e-3 * softest / (density * size * size);
}

// From here on materials differ so much that rounding in the stiff ones is felt in the soft ones.
constexpr double kContrast = 1e6;

// How many times stiffer the stiffest material is than the softest.
double stiffness_ratio(const Solid& solid) {
  double low = std::numeric_limits<double>::max(), high = 0;
  for (const Elasticity& elasticity : solid.elasticities) {
    low = std::min(low, elasticity.tensor.norm());
    high = std::max(high, elasticity.tensor.norm());
  }
  return high / low;
}

// A hinge or a joint of one vertex lets a part move without strain: K is singular although enough
// vertices are fixed, and what a factorisation then returns is noise.
void require_no_mechanism(const Problem& problem, const Solid& solid, const Modes& modes,
                          const Eigen::MatrixXd& psi) {
  // psi^T K psi is a sum in which terms cancel. A double has 2e-16, the factorisation loses some; a
  // cantilever a thousand times as long as thick keeps 1e-13.
  constexpr double kNoise = 2e-14;
  if (modes.cancellation > kNoise && psi.allFinite()) return;
  std::string where;
  Eigen::Index row = 0;
  if (psi.allFinite() && psi.col(0).cwiseAbs().maxCoeff(&row) > 0) {
    const Eigen::Vector3d& x = problem.mesh.vertices[static_cast<std::size_t>(row / 3)];
    where = text(" near vertex %d at %g, %g, %g", static_cast<int>(row / 3), x.x(), x.y(), x.z());
  }
  // Of a stiff part on a soft one rounding leaves as little.
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    where += text(
        " (or: the materials differ %.0e times in stiffness, too much for this machine's numbers)",
        ratio);
  throw Failure(content_error(
      "a part of the mesh" + where +
      " moves without strain: it hangs by a vertex or an edge only. Join it by faces, or fix it"));
}

// residual: of the modes, what they are judged by.
void require_accurate(const PrecomputeFindings& findings, const Solid& solid, double residual) {
  // Far above what a sound mesh gives (1e-9, 1e-14 and 1e-12), far below what harms. Of a beam, one
  // half a million times as stiff as the other, 4e-6 is left.
  const double tolerance = solid.uniform() ? 1e-6 : 1e-4;
  if (residual <= tolerance && findings.orthonormality_error <= 1e-9 &&
      findings.polynomial_error <= 1e-9)
    return;
  std::string question = "is the mesh extremely thin or uneven";
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    question += text(", do the materials differ too much (%.0e times in stiffness)", ratio);
  throw Failure({ErrorKind::kSolver,
                 text("the result is not accurate: residual of the modes %.1e, of the derivatives "
                      "%.1e, |U^T M U - I| %.1e, polynomial %.1e; ",
                      residual, findings.derivative_residual, findings.orthonormality_error,
                      findings.polynomial_error) +
                     question + ", or does a PETSc option change the factorisation?"});
}

// Of what vibrates: vertices of no tetrahedron may lie anywhere.
double body_size(const Problem& problem) {
  std::vector<Eigen::Vector3d> used;
  for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v)
    if (problem.report.part_of_vertex[v] >= 0) used.push_back(problem.mesh.vertices[v]);
  return bounding_box(used).diagonal();
}

// The first mode's coordinate when it moves some vertex by `reach` metres.
double amplitude_of_first_mode(const Eigen::MatrixXd& psi, double reach) {
  double largest = 0;
  for (Eigen::Index row = 0; row < psi.rows(); row += 3)
    largest = std::max(largest, psi.col(0).segment<3>(row).norm());
  return reach / largest;
}

VertexBlock make_block(const TetMesh& mesh, const std::vector<VertexId>& ids,
                       const BasisRows& basis) {
  VertexBlock block;
  block.vertex_ids = ids;
  block.rows.resize(3 * static_cast<Eigen::Index>(ids.size()), basis.cols());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    block.rest.push_back(mesh.vertices[ids[i]]);
    block.rows.middleRows(3 * static_cast<Eigen::Index>(i), 3) =
        basis.middleRows(3 * Eigen::Index{ids[i]}, 3);
  }
  return block;
}

}  // namespace

void add_geometry(const Problem& problem, const BasisRows& basis, BasisData& data) {
  const TetMesh& mesh = problem.mesh;
  const BoundarySurface boundary = boundary_surface(mesh);
  std::vector<VertexId> interior;
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v)
    if (!std::binary_search(boundary.vertex_ids.begin(), boundary.vertex_ids.end(), v))
      interior.push_back(v);
  data.surface = make_block(mesh, boundary.vertex_ids, basis);
  data.interior = make_block(mesh, interior, basis);
  data.triangles = boundary.triangles;
  if (problem.render)
    data.render = RenderBlock{*problem.render,
                              embedded_rows(problem.embedding, mesh, basis),
                              heaviest_vertices(problem.embedding, mesh),
                              {}};
  data.vertex_count = mesh.vertices.size();
  data.tetrahedron_count = mesh.tetrahedra.size();
  data.fixed_vertices = problem.fixed;
  data.fixed_vertex_count = problem.fixed.size();
  data.load = problem.load;
}

namespace {

Coefficients compute_coefficients(const Solid& solid, const BasisRows& basis, unsigned threads) {
  // Ranks share the elements; every rank ends up with the sum.
  const std::size_t m = solid.samples.size();
  const auto rank = static_cast<std::size_t>(mpi_rank());
  const auto ranks = static_cast<std::size_t>(mpi_ranks());
  Eigen::MatrixXd gram =
      strain_gram(solid, basis, m * rank / ranks, m * (rank + 1) / ranks, threads);
  sum_over_ranks(gram);
  return coefficients_from_gram(gram, static_cast<int>(basis.cols()));
}

double cholesky_bytes(const SparseCholesky& factor) {
  return 8.0 * static_cast<double>(factor.entries());
}

// Columns solved for on the factor, `width` in one pass over it forwards and one backwards.
StageWork solves_on(const SparseCholesky& factor, int columns, int width) {
  StageWork work;
  work.flops = 4.0 * static_cast<double>(factor.entries()) * columns;
  work.factor_bytes = cholesky_bytes(factor);
  work.passes = 2.0 * ((columns + width - 1) / width);
  return work;
}

void set_limit(const MachineLimits& machine, const StageWork& work, StageLog& log) {
  const StageLimit limit = stage_limit(machine, work);
  if (limit.seconds > 0) log.limit(limit.seconds, limit.reason);
}

// One material is what the user asked for; several are told.
void note_materials(const Problem& problem, const Solid& solid, StageLog& log) {
  const MaterialTable& table = problem.materials;
  const std::vector<MaterialShare> shares = material_shares(table, problem.mesh);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const NamedMaterial& named = table.materials[i];
    if (shares.size() == 1 && !named.material.orthotropic) break;
    log.note(
        named.name + ": " + std::to_string(shares[i].tetrahedra) + " tetrahedra, " +
        text("%.4g m^3, %.4g kg", shares[i].volume, shares[i].volume * named.material.density) +
        ", " + describe(named.material));
  }
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    log.note(text("the stiffest material is %.0e times as stiff as the softest: digits are lost",
                  ratio));
  for (const PointMass& mass : problem.point_masses)
    log.note(text("%.4g kg on %zu vertices: ", mass.kilograms, mass.vertices.size()) +
             mass.selector);
}

}  // namespace

PrecomputeResult run_precompute(const PrecomputeOptions& options, StageLog& log) {
  PrecomputeResult result;
  PrecomputeFindings& findings = result.findings;
  BasisData& data = result.data;

  log.begin("mesh");
  result.problem = load_problem(options);
  const Problem& problem = result.problem;
  const DofMap map = make_dof_map(problem.mesh, problem.fixed, mpi_ranks());
  const LocalDofs local = local_dofs(problem.mesh, map, mpi_rank());
  const auto parts = static_cast<int>(problem.report.parts);
  const int rigid_count = problem.free_body ? 6 * parts : 0;
  const ModeCounts counts = choose_mode_counts(options, 3 * map.nodes() - rigid_count);
  log.end(text("%zu vertices, %zu tetrahedra, %zu fixed vertices", problem.mesh.vertices.size(),
               problem.mesh.tetrahedra.size(), problem.fixed.size()));
  for (const std::string& note : problem.notes) log.note(note);

  // The fronts of a small factor are too small to share: more threads only wait for each other.
  constexpr int kSmall = 100'000;  // dofs
  const BlasThreads blas(3 * map.nodes() < kSmall ? 1 : static_cast<int>(options.threads));

  MachineLimits machine;
  if (options.limits && mpi_ranks() == 1) {
    log.begin("machine");
    machine = measure_machine(options.threads);
    log.end(text("%.4g GFLOP/s, %.4g GB/s read on %u threads", 1e-9 * machine.flops,
                 1e-9 * machine.bytes, options.threads));
  }

  log.begin("matrices");
  Solid solid = make_solid(problem.mesh, problem.materials);
  solid.point_mass = mass_of_vertices(problem.point_masses, problem.mesh.vertices.size());
  const Matrices matrices = assemble(solid, map, local, options.mass);
  data.total_mass = total_mass(solid);
  log.end(text("%d dofs, %.6g kg", 3 * map.nodes(), data.total_mass));
  note_materials(problem, solid, log);

  log.begin("modes");
  const Columns rigid = problem.free_body ? rigid_modes(problem.mesh, problem.report.part_of_vertex,
                                                        parts, local, matrices.mass.get())
                                          : Columns(local.dofs(), 0);
  Modes modes =
      compute_modes(matrices, counts.linear, rigid, choose_shift(problem, solid), options.threads);
  // A thin free body is far softer than a compact one: its derivatives want a smaller shift. One
  // with a small soft part is far stiffer than that part: so near to zero, K loses its digits.
  const double lowest = modes.squared_frequencies[0];
  if (problem.free_body && lowest > 0 &&
      (-modes.shift > 0.1 * lowest || -modes.shift < 1e-7 * lowest))
    modes = compute_modes(matrices, counts.linear, rigid, -0.02 * lowest, options.threads);
  Eigen::MatrixXd psi = expand_to_vertices(map, local, modes.vectors);
  require_no_mechanism(problem, solid, modes, psi);
  fix_signs(modes.vectors, psi);
  findings.factorisation = modes.factorisation;
  findings.mode_solver = modes.solver;
  findings.mode_residuals.assign(modes.residuals.begin(), modes.residuals.end());
  // Where stiff and soft parts meet, the rounding of large forces that balance in the stiff ones
  // would drown the small ones: rows are compared in units of their own stiffness.
  const double mode_residual = solid.uniform() ? modes.residuals.maxCoeff() : modes.scaled_residual;
  data.linear_mode_count = static_cast<std::uint64_t>(counts.linear);
  data.rigid_mode_count = static_cast<std::uint64_t>(rigid_count);
  double factor_flops = 0;
  if (modes.cholesky != nullptr) {
    factor_flops = modes.cholesky->flops();
    StageWork work = solves_on(*modes.cholesky, modes.solves, kLanczosBlock);
    work.added_flops = factor_flops;
    set_limit(machine, work, log);
  }
  log.end(text("%d modes, %.4g to %.4g Hz, residual %.1e, %s", counts.linear,
               hertz(modes.squared_frequencies[0]),
               hertz(modes.squared_frequencies[counts.linear - 1]), modes.residuals.maxCoeff(),
               modes.factorisation.c_str()));
  if (problem.free_body)
    log.note(text("a free body: its %d rigid motions are left out of the basis", rigid_count));

  ModalDerivatives derivatives;
  if (options.linear) {
    derivatives = {modes.vectors, modes.vectors.cols(), 0.0};
  } else {
    log.begin("derivatives");
    derivatives = modal_derivatives(solid, local, matrices, modes, psi, rigid, options.threads);
    findings.derivative_residual = derivatives.residual;
    if (modes.cholesky != nullptr)
      set_limit(machine,
                solves_on(*modes.cholesky, static_cast<int>(derivatives.vectors().cols()),
                          2 * static_cast<int>(kLanes)),
                log);
    log.end(text("%d solves on the factor of the modes, residual %.1e",
                 static_cast<int>(derivatives.vectors().cols()), derivatives.residual));
  }

  // Only now: the certificate takes the factor's memory.
  if (options.certify) {
    log.begin("certificate");
    const InertiaCertificate certificate = certify(matrices, modes, rigid_count, options.threads);
    findings.certified = certificate.complete();
    findings.inertia_count = certificate.counted;
    if (!certificate.complete())
      throw Failure({ErrorKind::kSolver,
                     text("modes were missed: inertia counts %d below %.6g Hz, %d were found",
                          certificate.counted, hertz(certificate.bound), certificate.expected)});
    set_limit(machine, {.flops = factor_flops}, log);
    log.end(text("inertia counts the same %d modes below %.4g Hz, %s", certificate.counted,
                 hertz(certificate.bound), certificate.solver.c_str()));
  }

  modes.cholesky.reset();

  log.begin("basis");
  // Two Gram matrices by half their entries and one change of the columns.
  const double columns = static_cast<double>(derivatives.columns.cols());
  set_limit(machine, {.flops = 4.0 * static_cast<double>(local.dofs()) * columns * columns}, log);
  // Motion that Tremolo is made for: a tenth of the body's size.
  constexpr double kReach = 0.1;
  const double amplitude = amplitude_of_first_mode(psi, kReach * body_size(problem));
  Basis basis = make_basis(matrices, std::move(derivatives.columns), modes.squared_frequencies,
                           amplitude, counts.modes, options.threads);
  Eigen::MatrixXd expanded = expand_to_vertices(map, local, basis.vectors);
  fix_signs(basis.vectors, expanded);
  const BasisRows rows = expanded;
  findings.orthonormality_error = basis.orthonormality_error;
  findings.diagonality_error = basis.diagonality_error;
  data.lambda = basis.lambda;
  data.singular_values = basis.singular_values;
  log.end(text("%d coordinates, |U^T M U - I| = %.1e, first singular value cut %.1e of the largest",
               counts.modes, basis.orthonormality_error,
               counts.modes < static_cast<int>(basis.singular_values.size())
                   ? basis.singular_values[counts.modes] / basis.singular_values[0]
                   : 0.0));

  if (!options.linear) {
    log.begin("coefficients");
    const auto r = static_cast<std::size_t>(counts.modes);
    const double strain_columns = static_cast<double>(r + pair_count(r));
    set_limit(machine,
              {.flops = 6.0 * static_cast<double>(problem.mesh.tetrahedra.size()) * strain_columns *
                        (strain_columns + 1.0)},
              log);
    Coefficients coefficients = compute_coefficients(solid, rows, options.threads);
    data.cubic = std::move(coefficients.cubic);
    data.quartic = std::move(coefficients.quartic);
    findings.polynomial_error =
        polynomial_error(solid, rows, data.lambda, data.cubic, data.quartic,
                         0.5 * bounding_box(problem.mesh.vertices).diagonal());
    log.end(text("%zu unique entries, |U^T f(Uq) - grad V| = %.1e relative",
                 data.cubic.size() + data.quartic.size(), findings.polynomial_error));
  }

  require_accurate(findings, solid, mode_residual);

  add_geometry(problem, rows, data);
  return result;
}

}  // namespace tremolo
