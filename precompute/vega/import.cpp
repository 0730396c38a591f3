#include "precompute/vega/import.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "common/hash.h"
#include "common/text.h"
#include "formats/file/input_file.h"
#include "formats/surface/surface_reader.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/problem/model_geometry.h"
#include "precompute/problem/preview.h"
#include "precompute/system/failure.h"
#include "precompute/vega/reduced_tensors.h"

namespace tremolo {
namespace {

// Errors of a mesh written with six digits and a basis in single precision stay below this; the
// relative error of a frequency is at most half of it.
constexpr double kOrthonormal = 1e-4;
// Entries this small relative to the largest of their column are rounding: a solver leaves 1e-14 at
// held vertices, and a displacement of 1e-12 of the largest has no visible effect.
constexpr double kRounding = 1e-12;
// Rounding of sums over a million tetrahedra stays far below this.
constexpr double kAsymmetry = 1e-9;

[[noreturn]] void refuse(const std::string& message) {
  throw Failure(content_error(message));
}

double distance_from_identity(const Eigen::MatrixXd& gram) {
  return (gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff();
}

std::string hash_file(const std::string& bytes) {
  return hash_text(hash_bytes(std::as_bytes(std::span(bytes))));
}

// Expands the file's rows to all vertices, with zero rows at fixed ones.
BasisRows expand_rows(const ImportRequest& request, const Problem& problem,
                      const Eigen::MatrixXd& basis) {
  const std::size_t n = problem.mesh.vertices.size();
  const std::size_t fixed = problem.fixed.size();
  const std::size_t rows = basis.rows();
  if (rows == 3 * n) return basis;
  const std::string counts = request.basis_path + " has " + std::to_string(rows) + " rows, " +
                             request.solid.files.mesh + " has " + std::to_string(n) +
                             " vertices: expected " + std::to_string(3 * n) +
                             " rows, three a vertex";
  if (fixed == 0)
    refuse(counts + " (if those of fixed vertices are left out, name these with --fix)");
  if (rows != 3 * (n - fixed))
    refuse(counts + ", or " + std::to_string(3 * (n - fixed)) + " without the " +
           std::to_string(fixed) + " fixed ones");
  BasisRows expanded = BasisRows::Zero(3 * n, basis.cols());
  Eigen::Index next = 0;
  for (VertexId v = 0; v < static_cast<VertexId>(n); ++v) {
    if (std::binary_search(problem.fixed.begin(), problem.fixed.end(), v)) continue;
    expanded.middleRows(3 * Eigen::Index{v}, 3) = basis.middleRows(next, 3);
    next += 3;
  }
  return expanded;
}

// Returns the largest entry of a vertex's rows, each relative to the largest of its column.
double largest_share(const BasisRows& basis, const Eigen::RowVectorXd& largest, VertexId v) {
  const Eigen::Index r = basis.cols();
  double share = 0;
  for (Eigen::Index i = 0; i < r; ++i)
    if (largest[i] > 0)
      share = std::max(
          share, basis.col(i).segment<3>(3 * Eigen::Index{v}).cwiseAbs().maxCoeff() / largest[i]);
  return share;
}

// Makes basis and fixed vertices agree: vertices that the basis does not move become fixed, and
// rounding in the rows of fixed vertices is set to zero.
void reconcile_fixed(const ImportRequest& request, BasisRows& basis, Problem& problem) {
  const Eigen::RowVectorXd largest = basis.cwiseAbs().colwise().maxCoeff();
  double left = 0;
  const auto hold = [&](VertexId v, double share) {
    left = std::max(left, share);
    basis.middleRows(3 * Eigen::Index{v}, 3).setZero();
  };
  for (VertexId v : problem.fixed) {
    const double share = largest_share(basis, largest, v);
    if (share > kRounding)
      refuse(request.basis_path + ": the rows of vertex " + std::to_string(v) +
             text(" are not zero (up to %.1e of the largest entries of their columns; rounding is "
                  "below %.0e), but --fix holds it",
                  share, kRounding));
    hold(v, share);
  }
  if (!problem.free_body && problem.fixed.empty()) {
    for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertices.size()); ++v) {
      if (problem.report.part_of_vertex[v] < 0) continue;
      const double share = largest_share(basis, largest, v);
      if (share > kRounding) continue;
      problem.fixed.push_back(v);
      hold(v, share);
    }
    problem.free_body = problem.fixed.empty();
    if (request.solid.load) problem.load = make_load(*request.solid.load, problem);
  }
  if (left > 0)
    problem.notes.push_back(
        text("the rows of held vertices have entries of up to %.1e of the largest: rounding, taken "
             "as zero",
             left));
}

std::vector<double> element_densities(const Problem& problem) {
  std::vector<double> densities;
  densities.reserve(problem.mesh.tetrahedra.size());
  for (std::size_t t = 0; t < problem.mesh.tetrahedra.size(); ++t)
    densities.push_back(problem.materials.of(t).density);
  return densities;
}

// Selects the mass and returns G, or none if the basis is orthonormal already.
std::optional<Eigen::MatrixXd> choose_mass(const ImportRequest& request, const TetMesh& mesh,
                                           const std::vector<double>& density,
                                           const BasisRows& basis, ImportFindings& findings,
                                           std::vector<std::string>& notes) {
  const Eigen::MatrixXd lumped = reduced_mass(mesh, density, basis, MassKind::kLumped);
  const Eigen::MatrixXd consistent = reduced_mass(mesh, density, basis, MassKind::kConsistent);
  findings.lumped_error = distance_from_identity(lumped);
  findings.consistent_error = distance_from_identity(consistent);
  // On a fine mesh both masses fit: the better one is taken.
  const bool consistent_fits = findings.consistent_error <= kOrthonormal &&
                               findings.consistent_error < findings.lumped_error;
  findings.mass = request.mass_given ? request.solid.elements.mass
                  : consistent_fits  ? MassKind::kConsistent
                                     : MassKind::kLumped;
  const bool is_lumped = findings.mass == MassKind::kLumped;
  const double error = is_lumped ? findings.lumped_error : findings.consistent_error;
  const Eigen::MatrixXd& gram = is_lumped ? lumped : consistent;
  const char* name = is_lumped ? "lumped" : "consistent";
  if (error <= kOrthonormal) {
    notes.push_back(
        text("the basis is orthonormal in the %s mass, off by %.1e; that is the "
             "model's mass",
             name, error));
    return std::nullopt;
  }
  if (!request.mass_given) {
    // A basis for another density shows as U^T M U being a multiple of the identity.
    const double factor = lumped.trace() / static_cast<double>(lumped.rows());
    const bool scaled = factor > 0 && distance_from_identity(lumped / factor) <= kOrthonormal;
    refuse(request.basis_path +
           text(": U^T M U is off the identity by %.2g in the lumped mass "
                "(VegaFEM's) and by %.2g in the consistent one. ",
                findings.lumped_error, findings.consistent_error) +
           (scaled
                ? text("It is %.6g times the identity: the basis belongs to a density %.6g times "
                       "as large, see --density",
                       factor, 1.0 / factor)
                : "Check --density and that the mesh is the basis's own; --mass lumped or --mass "
                  "consistent takes the basis as it is and makes it orthonormal in that mass"));
  }
  findings.orthonormalised = true;
  notes.push_back(text("the basis was not orthonormal in the %s mass, off by %.2g, and was made so",
                       name, error));
  return gram;
}

// The change of coordinates R, and lambda. If L is diagonal R is a permutation, so values are kept.
struct Coordinates {
  Eigen::MatrixXd change;  // R
  Eigen::VectorXd lambda;
};

Coordinates diagonalise(const Eigen::MatrixXd& stiffness,
                        const std::optional<Eigen::MatrixXd>& mass) {
  const Eigen::Index r = stiffness.rows();
  if (mass) {
    const EigenPairs pairs = eigenpairs(stiffness, *mass);
    const Eigen::VectorXd sizes = eigenpairs(*mass).values;
    if (!(sizes[0] > 1e-12 * sizes[r - 1]) || !pairs.found)
      refuse("the basis cannot be made orthonormal: its columns depend on each other");
    return {pairs.vectors, pairs.values};
  }
  if (!stiffness.isDiagonal(0)) {
    const EigenPairs pairs = eigenpairs(stiffness);
    if (!pairs.found) refuse("the linear terms of the .cub have no eigenvalues");
    return {pairs.vectors, pairs.values};
  }
  std::vector<Eigen::Index> order(r);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return stiffness(a, a) < stiffness(b, b);
  });
  Coordinates result{Eigen::MatrixXd::Zero(r, r), Eigen::VectorXd(r)};
  for (Eigen::Index i = 0; i < r; ++i) {
    const Eigen::Index from = order[i];
    result.change(from, i) = 1.0;
    result.lambda[i] = stiffness(from, from);
  }
  return result;
}

void require_stiff(const Eigen::VectorXd& lambda, const std::string& path) {
  const double highest = lambda[lambda.size() - 1];
  if (lambda[0] > 1e-12 * highest) return;
  refuse(path + text(": the linear terms have the squared frequency %.3g (the largest is %.3g "
                     "rad^2/s^2): a rigid motion is in the basis, or a stiffness is negative. "
                     "Leave such columns out",
                     lambda[0], highest));
}

// Measures the error at three motions of the size Tremolo is meant for: coordinates have at most
// equal energy, and the largest vertex displacement is a tenth of the body's size.
double measure_force_error(const ReducedForces& forces, const Coordinates& coordinates,
                           const ReducedTensors& tensors, const BasisRows& basis, double reach) {
  std::mt19937 generator(1);
  double worst = 0;
  for (int probe = 0; probe < 3; ++probe) {
    Eigen::VectorXd q = coordinates.lambda.cwiseSqrt().cwiseInverse();
    for (double& value : q) value *= static_cast<double>(generator()) * 0x1p-31 - 1.0;
    const Eigen::VectorXd moved = basis * q;
    double largest = 0;
    for (Eigen::Index row = 0; row < moved.size(); row += 3)
      largest = std::max(largest, moved.segment<3>(row).norm());
    q *= reach / largest;
    const Eigen::VectorXd source =
        coordinates.change.transpose() * evaluate(forces, coordinates.change * q);
    worst = std::max(worst, (gradient(tensors, q) - source).norm() / source.norm());
  }
  return worst;
}

void require_finite(const BasisData& data, const BasisRows& basis) {
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  };
  if (!basis.allFinite() || !data.lambda.allFinite() || !finite(data.cubic) ||
      !finite(data.quartic))
    refuse("the numbers of the imported files are too large to compute with");
}

// Parsed contents of the files; data.vega keeps the files themselves for the export.
struct Source {
  Eigen::MatrixXd basis;
  ReducedForces forces;
};

Source read_source(const ImportRequest& request, BasisData& data, ImportFindings& findings) {
  data.vega.basis = unwrap(read_whole_file(request.basis_path));
  data.vega.cubic = unwrap(read_whole_file(request.cubic_path));
  findings.basis_hash = hash_file(data.vega.basis);
  findings.cubic_hash = hash_file(data.vega.cubic);
  Source source{unwrap(read_basis_matrix(data.vega.basis, request.basis_path)),
                unwrap(read_cub(data.vega.cubic, request.cubic_path))};
  if (static_cast<std::size_t>(source.basis.cols()) != source.forces.size)
    refuse(request.basis_path + " has " + std::to_string(source.basis.cols()) + " columns, " +
           request.cubic_path + " has " + std::to_string(source.forces.size) + " coordinates");
  return source;
}

// Computes Lambda, C and Q of `data`. basis: U on entry, U R on return.
void compute_model(const ImportRequest& request, const ReducedForces& forces, BasisRows& basis,
                   ImportResult& result) {
  BasisData& data = result.data;
  const TetMesh& mesh = result.problem.mesh;
  ImportFindings& findings = result.findings;
  const std::vector<double> density = element_densities(result.problem);
  const std::optional<Eigen::MatrixXd> mass =
      choose_mass(request, mesh, density, basis, findings, result.problem.notes);
  const SymmetrisedForces symmetric = symmetrise(forces);
  findings.asymmetry = symmetric.asymmetry;
  if (!(findings.asymmetry <= kAsymmetry))
    refuse(request.cubic_path +
           text(": the forces have no potential: equal terms of two components differ by %.2g of "
                "the largest, expected rounding, below %.0e",
                findings.asymmetry, kAsymmetry));
  const Coordinates coordinates = diagonalise(symmetric.tensors.quadratic, mass);
  require_stiff(coordinates.lambda, request.cubic_path);
  ReducedTensors tensors = change_coordinates(symmetric.tensors, coordinates.change);
  tensors.quadratic = coordinates.lambda.asDiagonal();
  basis = basis * coordinates.change;
  findings.orthonormality_error =
      distance_from_identity(reduced_mass(mesh, density, basis, findings.mass));
  findings.force_error = measure_force_error(forces, coordinates, tensors, basis,
                                             0.1 * bounding_box(mesh.vertices).diagonal());
  data.lambda = coordinates.lambda;
  data.cubic = std::move(tensors.cubic);
  data.quartic = std::move(tensors.quartic);
  require_finite(data, basis);
  for (std::size_t e = 0; e < density.size(); ++e)
    data.total_mass += density[e] * signed_volume(mesh, mesh.tetrahedra[e]);
}

// basis: 3n x r.
void add_rows(const Problem& problem, const BasisRows& basis, BasisData& data) {
  for (VertexBlock* block : {&data.surface, &data.interior}) {
    block->rows.resize(3 * static_cast<Eigen::Index>(block->vertex_ids.size()), basis.cols());
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      block->rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) =
          basis.middleRows<3>(3 * Eigen::Index{block->vertex_ids[i]});
  }
  if (data.render) data.render->rows = embedded_rows(problem.embedding, problem.mesh, basis);
}

}  // namespace

ImportResult import_reduced(const ImportRequest& request, StageLog& log) {
  if (is_surface_file(request.solid.files.mesh))
    throw Failure({ErrorKind::kUsage, request.solid.files.mesh +
                                          ": an imported basis needs the tetrahedral mesh that it "
                                          "was made for, not a surface"});
  if (!request.solid.point_masses.empty())
    throw Failure({ErrorKind::kUsage,
                   "--point-mass has no place in an imported model: its basis belongs to the mass "
                   "that it was made with"});
  ImportResult result;
  Problem& problem = result.problem;
  BasisData& data = result.data;

  log.begin("mesh");
  problem = load_problem(request.solid);
  write_preview(request.output.preview, problem);
  log.end(text("%zu vertices, %zu tetrahedra", problem.mesh.vertices.size(),
               problem.mesh.tetrahedra.size()));

  log.begin("import");
  const Source source = read_source(request, data, result.findings);
  BasisRows basis = expand_rows(request, problem, source.basis);
  reconcile_fixed(request, basis, problem);
  log.end(text("%zu coordinates, %zu fixed vertices", source.forces.size, problem.fixed.size()));

  log.begin("coordinates");
  compute_model(request, source.forces, basis, result);
  log.end(text("forces equal to those of the .cub within %.1e", result.findings.force_error));

  data.rigid_mode_count = problem.free_body ? 6 * problem.report.parts : 0;
  add_geometry(problem, data);
  add_rows(problem, basis, data);
  if (problem.free_body) problem.notes.emplace_back("a free body: no vertex is fixed");
  for (const std::string& note : problem.notes) log.note(note);
  return result;
}

}  // namespace tremolo
