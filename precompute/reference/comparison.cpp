#include "precompute/reference/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "common/text.h"
#include "precompute/fem/control_values.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require_same_mesh(const FullOrder& body, const BasisData& data, const std::string& mesh_hash,
                       const std::string& name) {
  const auto provenance = nlohmann::json::parse(data.provenance, nullptr, false);
  const auto mesh = provenance.is_object() ? provenance.find("mesh") : provenance.end();
  const std::string hash =
      mesh != provenance.end() && mesh->is_object() && mesh->contains("xxh3_64")
          ? mesh->value("xxh3_64", "")
          : "";
  if (hash == mesh_hash && data.edges.size() != body.solid.mesh.edges.size())
    throw Failure(content_error(name + ": made with elements of order " +
                                (data.edges.empty() ? "1" : "2") + ": give the same --order here"));
  if (hash != mesh_hash || data.vertex_count != body.solid.mesh.vertices.size())
    throw Failure(content_error(name + ": made of another mesh (hash " +
                                (hash.empty() ? "unknown" : hash) + ", this one's is " + mesh_hash +
                                "): compare it with its own"));
}

// The opposite case is checked in basis_of_unknowns, where a held vertex of the basis would only
// show as zero rows.
void require_same_fix(const FullOrder& body, const BasisData& data, const std::string& name) {
  const auto moves = [&body](VertexId v) {
    return std::any_of(body.unknowns.of_dof.begin() + 3 * std::ptrdiff_t{v},
                       body.unknowns.of_dof.begin() + 3 * std::ptrdiff_t{v} + 3,
                       [](int unknown) { return unknown >= 0; });
  };
  for (const VertexId v : data.fixed_vertices)
    if (moves(v))
      throw Failure(content_error(name + ": its vertex " + std::to_string(v) +
                                  " is held, which moves here: give the same --fix as when it was "
                                  "made"));
}

// Returns the rows of the basis at the body's unknowns; throws if a component held here moves in
// the basis.
Eigen::MatrixXd basis_of_unknowns(const FullOrder& body, const BasisData& data, Eigen::Index r,
                                  const std::string& name) {
  const TetMesh& mesh = body.solid.mesh;
  const Eigen::Index vertices = mesh.vertices.size();
  BasisRows rows = BasisRows::Zero(3 * vertices, r);
  for (const VertexBlock* block : {&data.surface, &data.interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      rows.middleRows<3>(3 * Eigen::Index{block->vertex_ids[i]}) =
          block->rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)).leftCols(r);
  to_control_values(mesh, rows);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(body.size(), r);
  for (Eigen::Index dof = 0; dof < rows.rows(); ++dof) {
    if (const int unknown = body.unknowns.of_dof[dof]; unknown >= 0)
      basis.row(unknown) = rows.row(dof);
    else if (!rows.row(dof).isZero(0.0))
      throw Failure(
          content_error(name + ": its vertex " + std::to_string(dof / 3) +
                        " moves, which is held here: give the same --fix as when it was made"));
  }
  return basis;
}

// Bounds the rounding of u^T K u: that of the sums of |u_i K_ij u_j|, here and in the file's
// making. Of a bar of 200 thicknesses they are 1e9 times their result.
double rounding_of_product(const FullOrder& body, const Vector& u) {
  std::vector<double> sizes(body.stiffness.size());
  std::transform(body.stiffness.begin(), body.stiffness.end(), sizes.begin(),
                 [](double value) { return std::abs(value); });
  constexpr double kRoundings = 4.0;
  const Vector magnitudes = u.cwiseAbs();
  return kRoundings * std::numeric_limits<double>::epsilon() *
         magnitudes.dot(multiply(body, sizes, magnitudes));
}

// tolerance: tolerance of both errors, dimensionless; that of U^T K U plus rounding.
void require_same_body(const FullOrder& body, const ReducedBody& reduced, double tolerance,
                       const std::string& name) {
  const Eigen::Index r = reduced.model.size();
  const double mass_error =
      (reduced.basis.transpose() * reduced.mass_basis - Eigen::MatrixXd::Identity(r, r))
          .cwiseAbs()
          .maxCoeff();
  double stiffness_error = 0;
  bool same = mass_error <= tolerance;
  for (Eigen::Index i = 0; i < r; ++i) {
    const Vector column = reduced.basis.col(i);
    const double value = column.dot(multiply(body, body.stiffness, column));
    const double error = std::abs(value / reduced.model.lambda[i] - 1);
    stiffness_error = std::max(stiffness_error, error);
    if (error <= tolerance) continue;
    same = same && error - tolerance <=
                       rounding_of_product(body, column) / std::abs(reduced.model.lambda[i]);
  }
  if (same) return;
  throw Failure(content_error(
      name +
      text(": |U^T M U - I| is %.1e, U^T K U is off its values by %.1e: it was made with other "
           "materials, masses or held vertices; give the same here",
           mass_error, stiffness_error)));
}

double mass_product(const FullOrder& body, const Vector& a, const Vector& b) {
  return a.dot(multiply(body, body.mass, b));
}

}  // namespace

ReducedBody make_reduced_body(const FullOrder& body, ReducedModel model, Eigen::MatrixXd basis) {
  ReducedBody reduced{std::move(model), std::move(basis), {}};
  reduced.mass_basis.resize(reduced.basis.rows(), reduced.basis.cols());
  for (Eigen::Index i = 0; i < reduced.basis.cols(); ++i)
    reduced.mass_basis.col(i) = multiply(body, body.mass, reduced.basis.col(i));
  return reduced;
}

ReducedBody make_reduced_body(const FullOrder& body, const BasisData& data,
                              const std::string& mesh_hash, std::optional<int> modes,
                              const std::string& name) {
  require_same_mesh(body, data, mesh_hash, name);
  require_same_fix(body, data, name);
  const Eigen::Index all = data.lambda.size(), r = modes.value_or(static_cast<int>(all));
  if (r < 1 || r > all)
    throw Failure(content_error("--modes " + std::to_string(r) + ": " + name + " has " +
                                std::to_string(all)));
  ReducedBody reduced = make_reduced_body(
      body,
      first_coordinates(make_reduced_model(data.lambda, data.cubic, data.quartic, data.strain_gram),
                        r),
      basis_of_unknowns(body, data, r, name));
  const bool compact = data.surface.column_scales.size() > 0;
  require_same_body(body, reduced, compact ? 0.02 : 1e-6, name);
  return reduced;
}

Moment compare(const FullOrder& body, const ReducedBody& reduced, const Vector& u,
               const Vector& mass_u, const Vector& q, const std::vector<VertexId>& watched) {
  const Vector other = reduced.basis * q, mass_other = reduced.mass_basis * q;
  const Vector off = u - other;
  const Vector best = u - reduced.basis * (reduced.mass_basis.transpose() * u);
  const double square = u.dot(mass_u), other_square = other.dot(mass_other);
  Moment moment;
  moment.norm = std::sqrt(square);
  // The norm of a difference rather than a difference of squared norms, to keep digits of small
  // errors.
  moment.difference = std::sqrt(mass_product(body, off, off));
  moment.projection = std::sqrt(mass_product(body, best, best));
  if (square > 0 && other_square > 0)
    moment.mac = std::pow(mass_u.dot(other), 2) / (square * other_square);
  moment.tip = largest_displacement(body, watched, u);
  moment.tip_difference = largest_displacement(body, watched, off);
  return moment;
}

void compare_shown(const FullOrder& body, const ReducedBody& reduced, const Vector& u,
                   const Vector& q, const Vector& response, const std::vector<VertexId>& watched,
                   Moment& moment) {
  const Vector off = u - reduced.basis * q - response;
  moment.shown_difference = std::sqrt(mass_product(body, off, off));
  moment.shown_tip_difference = largest_displacement(body, watched, off);
}

ComparisonSummary summarise(const std::vector<Moment>& moments) {
  double largest = 0, tip = 0;
  for (const Moment& moment : moments) {
    largest = std::max(largest, moment.norm);
    tip = std::max(tip, moment.tip);
  }
  if (largest == 0) return {};
  const double watched = tip > 0 ? 0 : ComparisonSummary::kNone;
  ComparisonSummary summary{0, 0, 0, 0, watched, 1, 0, 0, watched};
  for (const Moment& moment : moments) {
    const auto keep = [](double& worst, double value) { worst = std::max(worst, value); };
    keep(summary.error_of_largest, moment.difference / largest);
    keep(summary.projection_of_largest, moment.projection / largest);
    if (tip > 0) keep(summary.tip_error_of_largest, moment.tip_difference / tip);
    keep(summary.shown_of_largest, moment.shown_difference / largest);
    if (tip > 0) keep(summary.shown_tip_of_largest, moment.shown_tip_difference / tip);
    if (std::abs(moment.energy_difference) > std::abs(summary.energy_difference))
      summary.energy_difference = moment.energy_difference;
    if (moment.norm < 0.1 * largest) continue;
    keep(summary.error_at_once, moment.difference / moment.norm);
    keep(summary.projection_at_once, moment.projection / moment.norm);
    summary.mac_least = std::min(summary.mac_least, moment.mac);
  }
  return summary;
}

Vector response_beyond(const ReducedBody& reduced, const Vector& load, const Vector& response) {
  const Vector reduced_load = reduced.basis.transpose() * load;
  return response - reduced.basis * (reduced_load.array() / reduced.model.lambda.array()).matrix();
}

double unseen_load(const ReducedBody& reduced, const Vector& load, const Vector& response) {
  const double compliance = load.dot(response);
  if (!(compliance > 0)) return std::numeric_limits<double>::quiet_NaN();
  const Vector reduced_load = reduced.basis.transpose() * load;
  return 1.0 - (reduced_load.array().square() / reduced.model.lambda.array()).sum() / compliance;
}

}  // namespace tremolo
